/* The watch of a restart search, control/restart_search.py: whether the law approaches its target.
 *
 * Its memory is the vector told there: state, quiet cycles, last error, least error, last posture (n).
 */
enum { R_PLACE, R_TOLERANCE, R_AT_REST, R_APPROACH, R_PATIENCE, R_COUNT };
enum { LAW_LEADS, SEARCHING, UNDERWAY, STUCK };

/* `RestartSearch.remember` of a cycle whose error (m) at q (n) is so long. 0: Python does it, nothing has
 * been written: the search begins, runs or drives. */
static int watch(const double *o, const double *chain, int n, const double *t, double *memory,
                 const double *target, const double *q, double size) {
    double error[6], *own = memory + 4, quiet = memory[1], least = memory[3], way = 0.0;
    const int state = (int)memory[0];
    if (state == UNDERWAY) return 0;
    if (size <= o[R_TOLERANCE]) { memset(memory, 0, sizeof(double) * 4); return 1; }
    if (state == SEARCHING) return 0;
    if (state == STUCK) {
        if (fabs(size - memory[3]) > fmax(o[R_TOLERANCE], 0.1 * memory[3]))
            memset(memory, 0, sizeof(double) * 4);
        return 1;
    }
    fikm_task(chain, n, t, target, own, error, NULL);
    double before = square_of(error, (int)t[T_ROWS]);
    before = before < LARGEST * LARGEST ? sqrt(before) : INFINITY;
    if (fabs(before - memory[2]) > 0.1 * o[R_TOLERANCE] || size < (1.0 - o[R_APPROACH]) * least)
        quiet = 0.0, least = size;
    else {
        for (int j = 0; j < n; j++) way += (q[j] - own[j]) * (q[j] - own[j]);
        quiet += sqrt(way) < o[R_AT_REST] * size ? 3.0 : 1.0;
    }
    if (!(quiet < o[R_PATIENCE])) return 0;
    memory[1] = quiet, memory[2] = size, memory[3] = least;
    memcpy(own, q, sizeof(double) * (size_t)n);
    return 1;
}
