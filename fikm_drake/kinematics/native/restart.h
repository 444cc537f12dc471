/* A restart search, control/restart_search.py: whether the law approaches its target, and the way down to a
 * posture. Its memory is the vector told there: state, quiet cycles or steps of the search, last error or
 * start, an error, a posture (n).
 */
enum { R_PLACE, R_TOLERANCE, R_AT_REST, R_APPROACH, R_PATIENCE, R_PACE, R_LANDING, R_NEAR, R_PASSED, R_LOST,
       R_COUNT };
enum { LAW_LEADS, SEARCHING, UNDERWAY, STUCK };

static double error_size(const double *error, int m) {
    double square = square_of(error, m);
    return square < LARGEST * LARGEST ? sqrt(square) : INFINITY;
}

static double farthest_of(const double *a, const double *b, int n) {
    double most = 0.0;
    for (int j = 0; j < n; j++) most = fmax(most, fabs(a[j] - b[j]));
    return most;
}

/* The step (n) of a search that drives to a posture: `RestartSearch.step`. */
static void drive(const double *r, const double *o, const Limits *l, const double *posture, const double *q,
                  double *step) {
    const int n = (int)o[C_JOINTS];
    double part = fmin(r[R_LANDING], r[R_PACE] / fmax(farthest_of(posture, q, n), 1e-300));
    for (int j = 0; j < n; j++) step[j] = (posture[j] - q[j]) * part;
    brakeable(o, l, step, n);
    shorten_by(step, l->fastest, n);
}

/* `RestartSearch._arrive`; whether the posture to which it drives now is passed. */
static int arrive(const double *r, const double *chain, int n, const double *t, double *memory,
                  const double *target, const double *posture, const double *q) {
    double error[6];
    fikm_task(chain, n, t, target, memory + 4, error, NULL);
    int lost = error_size(error, (int)t[T_ROWS]) > r[R_LOST] * r[R_TOLERANCE];
    memory[1] += 1.0;
    if (memory[1] >= 0.0 || lost || farthest_of(memory + 4, q, n) <= r[R_NEAR])
        memset(memory, 0, sizeof(double) * 4);
    return farthest_of(posture, q, n) <= r[R_PASSED];
}

/* `RestartSearch.remember` of a cycle whose error (m) at q (n) is so long, but for one that drives. 0: Python
 * does it, nothing has been written: the search begins or runs. */
static int watch(const double *o, const double *chain, int n, const double *t, double *memory,
                 const double *target, const double *q, double size) {
    double error[6], *own = memory + 4, quiet = memory[1], least = memory[3], way = 0.0;
    const int state = (int)memory[0];
    if (size <= o[R_TOLERANCE]) { memset(memory, 0, sizeof(double) * 4); return 1; }
    if (state == SEARCHING) return 0;
    if (state == STUCK) {
        if (fabs(size - memory[3]) > fmax(o[R_TOLERANCE], 0.1 * memory[3]))
            memset(memory, 0, sizeof(double) * 4);
        return 1;
    }
    fikm_task(chain, n, t, target, own, error, NULL);
    double moved = fabs(error_size(error, (int)t[T_ROWS]) - memory[2]);
    if (moved > 0.1 * o[R_TOLERANCE] || size < (1.0 - o[R_APPROACH]) * least)
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

enum { D_TOLERANCE, D_LIMIT, D_DAMPING, D_WINDOW, D_PROGRESS };

/* `RestartSearch._look` of at most so many steps; o are options of a step, d those of the search. How many
 * were taken: Python does the next, which arrives or gives up. */
int fikm_descend(const double *o, const double *d, const double *target, int looks, double *memory) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const Limits l = limits_of(o, n);
    double error[6], J[6 * MAX_JOINTS], step[MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS], *own = memory + 4;
    for (int j = 0; j < n; j++) low[j] = -INFINITY, high[j] = INFINITY;
    for (int look = 0; look < looks; look++) {
        fikm_task(l.chain, n, o + C_TASK, target, own, error, J);
        double size = error_size(error, m);
        if (!(size < INFINITY) || size <= 0.5 * d[D_TOLERANCE]) return look;
        const int looked_at = fmod(memory[1], d[D_WINDOW]) == 0.0;
        if (looked_at && memory[1] != 0.0 && size > (1.0 - d[D_PROGRESS]) * fmin(memory[3], d[D_LIMIT]))
            return look;
        for (int i = 0; i < m && size > d[D_LIMIT]; i++) error[i] *= d[D_LIMIT] / size;
        double damping = d[D_DAMPING] * sqrt(fmin(size / d[D_LIMIT], 1.0));
        if (safe_step(o, &l, own, J, error, damping, low, high, 1, step) == LEFT) return look;
        if (looked_at) memory[3] = size;
        for (int j = 0; j < n; j++) own[j] = clamped(own[j] + step[j], l.end_low[j], l.end_high[j]);
        memory[1] += 1.0;
    }
    return looks;
}

/* Lengths of the error at postures (count,n). */
void fikm_error_sizes(const double *o, const double *target, int64_t count, const double *postures,
                      double *sizes) {
    const int n = (int)o[C_JOINTS];
    const Limits l = limits_of(o, n);
    double error[6];
    for (int64_t i = 0; i < count; i++) {
        fikm_task(l.chain, n, o + C_TASK, target, postures + i * n, error, NULL);
        sizes[i] = error_size(error, (int)o[C_ROWS]);
    }
}
