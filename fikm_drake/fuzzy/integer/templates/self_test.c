
#ifdef ${NAME}_SELF_TEST
/* What fikm_drake infers, inside and outside the range. */
static const struct {
    int32_t x, y;
    int status;
    int32_t outputs[OUTPUTS];
} cases[$cases] = {
$expected
};

/* Returns 0 if every case comes out as in fikm_drake, else 1. */
int main(void)
{
    int32_t outputs[OUTPUTS];
    unsigned i, k;

    for (i = 0; i < $cases; i++) {
        if (${name}_infer(cases[i].x, cases[i].y, outputs) != cases[i].status)
            return 1;
        for (k = 0; k < OUTPUTS; k++)
            if (outputs[k] != cases[i].outputs[k])
                return 1;
    }
    return 0;
}
#endif
