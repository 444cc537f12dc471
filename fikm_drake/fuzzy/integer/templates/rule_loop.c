
/* Grade of membership `label` at `value`. */
static uint16_t grade(const int16_t *knots, unsigned labels, unsigned label, int32_t value)
{
    int32_t peak = knots[label];

    if (value < peak) {
        int32_t left = knots[label - 1];

        return value < left ? 0 : rise((wide)(value - left), (wide)(peak - left));
    }
    if (label + 1 < labels) {
        int32_t right = knots[label + 1];

        return value > right ? 0 : fall((wide)(value - peak), (wide)(right - peak));
    }
    return (uint16_t)grade_max;
}

/* Every rule, for one output: equations 4 and 5 as they stand. */
static int32_t infer_output(int32_t x, int32_t y, unsigned output)
{
    uint16_t y_grades[Y_LABELS];
    uint16_t total = 0;
    uint32_t sum = 0;
    unsigned i, j;

    for (j = 0; j < Y_LABELS; j++)
        y_grades[j] = grade(y_knots, Y_LABELS, j, y);
    for (i = 0; i < X_LABELS; i++) {
        uint16_t x_grade = grade(x_knots, X_LABELS, i, x);

        for (j = 0; j < Y_LABELS; j++) {
            uint16_t weight = both(x_grade, y_grades[j]);

            sum += (uint32_t)weight * singletons[i][j][output];
            total = (uint16_t)(total + weight);
        }
    }
    return average(sum, total, output);
}

int ${name}_infer(int32_t x, int32_t y, int32_t outputs[${NAME}_OUTPUTS])
{
    int outside = clamp(&x, &y);
    unsigned k;

    for (k = 0; k < OUTPUTS; k++)
        outputs[k] = infer_output(x, y, k);
    return outside;
}
