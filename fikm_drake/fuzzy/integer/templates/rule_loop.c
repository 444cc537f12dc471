
/* Grade of membership `label` at `value`. */
static uint32_t grade(const int16_t *knots, unsigned labels, unsigned label, int32_t value)
{
    int32_t peak = knots[label];

    if (value < peak) {
        int32_t left = knots[label - 1];

        return value < left ? 0 : rise((uint32_t)(value - left), (uint32_t)(peak - left));
    }
    if (label + 1 < labels) {
        int32_t right = knots[label + 1];

        return value > right ? 0 : fall((uint32_t)(value - peak), (uint32_t)(right - peak));
    }
    return grade_max;
}

/* Every rule, for one output: equations 4 and 5 as they stand. */
static int32_t infer_output(int32_t x, int32_t y, unsigned output)
{
    uint32_t y_grades[Y_LABELS];
    uint32_t sum = 0, total = 0;
    unsigned i, j;

    for (j = 0; j < Y_LABELS; j++)
        y_grades[j] = grade(y_knots, Y_LABELS, j, y);
    for (i = 0; i < X_LABELS; i++) {
        uint32_t x_grade = grade(x_knots, X_LABELS, i, x);

        for (j = 0; j < Y_LABELS; j++) {
            uint32_t weight = both(x_grade, y_grades[j]);

            sum += weight * singletons[i][j][output];
            total += weight;
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
