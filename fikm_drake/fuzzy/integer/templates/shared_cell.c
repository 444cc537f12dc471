
/* A cell of one input, and the grades of the memberships at its two ends. */
struct cell {
    unsigned index;
    uint16_t fall, rise;
};

/* The cell that holds `value`, which is in the range: the search ends at knots[0] at the latest. */
static struct cell locate(const int16_t *knots, unsigned labels, int32_t value)
{
    struct cell cell;
    wide offset, width;

    cell.index = labels - 2;
    while (value < knots[cell.index])
        cell.index--;
    offset = (wide)(value - knots[cell.index]);
    width = (wide)(knots[cell.index + 1] - knots[cell.index]);
    cell.rise = rise(offset, width);
    cell.fall = fall(offset, width);
    return cell;
}

/* The four rules of one cell serve all outputs. */
int ${name}_infer(int32_t x, int32_t y, int32_t outputs[${NAME}_OUTPUTS])
{
    int outside = clamp(&x, &y);
    struct cell a = locate(x_knots, X_LABELS, x);
    struct cell b = locate(y_knots, Y_LABELS, y);
    uint16_t w00 = both(a.fall, b.fall), w01 = both(a.fall, b.rise);
    uint16_t w10 = both(a.rise, b.fall), w11 = both(a.rise, b.rise);
    uint16_t total = (uint16_t)(w00 + w01 + w10 + w11);
    const uint16_t *s00 = singletons[a.index][b.index];
    const uint16_t *s01 = singletons[a.index][b.index + 1];
    const uint16_t *s10 = singletons[a.index + 1][b.index];
    const uint16_t *s11 = singletons[a.index + 1][b.index + 1];
    unsigned k;

    for (k = 0; k < OUTPUTS; k++) {
        uint32_t sum = (uint32_t)w00 * s00[k] + (uint32_t)w01 * s01[k];

        sum += (uint32_t)w10 * s10[k] + (uint32_t)w11 * s11[k];
        outputs[k] = average(sum, total, k);
    }
    return outside;
}
