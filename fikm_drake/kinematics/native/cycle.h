/* A control cycle as `control/cycle.py` tells it, as long as nothing out of the ordinary happens in it.
 *
 * What is out of the ordinary (an input that is not finite, a step that is too long or that a limit takes a
 * part of, equations that are nearly singular) is left to Python: then nothing has been written.
 */
enum { T_TURNS, T_LENGTH, T_ROWS, T_ROW, T_COUNT = T_ROW + 6 };
enum { C_ROWS, C_JOINTS, C_LONGEST, C_DEAD, C_SIDE_STEP, C_UNMOVED, C_WEIGHTS, C_PASSES, C_ROW_FLOOR,
       C_COLUMN_FLOOR, C_ZERO, C_DAMPING, C_GROWTH, C_TASK, C_LOWER = C_TASK + T_COUNT };
/* Then eight vectors of `Limits`, the chain, and for a whole cycle these, then the supervisor's. */
enum { K_ERROR_LIMIT, K_GAIN_SMOOTHING, K_ERROR_SMOOTHING, K_RATE, K_MEASURED, K_DAMPED, K_COUNT };
#define LARGEST 1e100

/* Error (m) and Jacobian (m,n), either may be NULL, of a task's rows: turns (times length), then offsets.
 * target: a pose, 3 rows of 4, or the rows' coordinates. What is not finite gives NaN. */
void fikm_task(const double *chain, int n, const double *t, const double *target, const double *q,
               double *error, double *J) {
    const int turns = t[T_TURNS] != 0.0, m = (int)t[T_ROWS];
    int bad = !(square_of(q, n) < LARGEST * LARGEST);
    vec lanes[MAX_JOINTS], columns[MAX_JOINTS][6], goal[12], e[6], distance, angle;
    Frames f;
    for (int j = 0; j < n; j++) lanes[j] = fill(q[j]);
    if (!bad) frames_of(chain, n, lanes, &f);
    if (error) {
        double far = 0.0;
        for (int i = 0; i < 12; i++) goal[i] = fill(0.0);
        for (int k = 0; turns && k < 3; k++) {
            for (int i = 0; i < 4; i++) {
                goal[3 * i + k] = fill(target[4 * k + i]);
                if (!isfinite(target[4 * k + i])) bad = 1;
            }
            far += target[4 * k + 3] * target[4 * k + 3];
        }
        if (!(far < LARGEST * LARGEST)) bad = 1;
        for (int i = 0; !turns && i < m; i++) goal[6 + (int)t[T_ROW + i]] = fill(target[i]);
        if (!bad && turns) error_of(&f, goal, 1, t[T_LENGTH], e, &distance, &angle);
        else if (!bad) error_of(&f, goal, 0, 1.0, e + 3, &distance, &angle);
        for (int i = 0; i < m; i++) error[i] = bad ? NAN : e[(int)t[T_ROW + i]][0];
    }
    if (!J) return;
    if (!bad) jacobian_of(chain, n, &f, turns ? t[T_LENGTH] : 1.0, columns);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) J[i * n + j] = bad ? NAN : columns[j][(int)t[T_ROW + i]][0];
}

/* The joints' limits and what is worked out of them, (n) each, then the chain. */
typedef struct {
    const double *lower, *upper, *fastest, *end_low, *end_high, *begin_low, *begin_high, *zone, *chain;
} Limits;

static Limits limits_of(const double *o, int n) {
    const double *x = o + C_LOWER;
    return (Limits){x, x + n, x + 2 * n, x + 3 * n, x + 4 * n, x + 5 * n, x + 6 * n, x + 7 * n, x + 8 * n};
}

static int law(const double *o, int m, int n, const double *J, const double *d, double extra, double *step) {
    return fikm_step(m, n, J, d, o[C_ROW_FLOOR], o[C_COLUMN_FLOOR], o[C_ZERO], o[C_DAMPING], extra,
                     o[C_GROWTH], step);
}

/* `SafeStep`: the law's step, near limits with weights, at a dead point aside. 0: left to Python. */
static int safe_step(const double *o, const Limits *l, int m, int n, const double *q, const double *J,
                     const double *d, double extra, double *step) {
    double weights[MAX_JOINTS], weighted[6 * MAX_JOINTS];
    int near = 0;
    if (law(o, m, n, J, d, extra, step)) return 0;
    for (int j = 0; o[C_WEIGHTS] != 0.0 && j < n; j++) {
        near |= q[j] - l->begin_low[j] < 0.0 || l->begin_high[j] - q[j] < 0.0;
        weights[j] = 1.0;
    }
    for (int pass = 0; near && pass < (int)o[C_PASSES]; pass++) {
        for (int j = 0; j < n; j++) {
            double way = step[j] > 0.0 ? l->end_high[j] - q[j] : q[j] - l->end_low[j];
            if (step[j] != 0.0) weights[j] = fmin(weights[j], fmax(0.0, fmin(1.0, way / l->zone[j])));
            for (int i = 0; i < m; i++) weighted[i * n + j] = J[i * n + j] * weights[j];
        }
        if (law(o, m, n, weighted, d, extra, step)) return 0;
        for (int j = 0; j < n; j++) step[j] *= weights[j];
    }
    double size = sqrt(square_of(step, n)), error = sqrt(square_of(d, m)), most = 0.0, reach[MAX_JOINTS];
    if (!(size <= o[C_LONGEST])) return 0;
    if (o[C_DEAD] == 0.0 || !(size < o[C_DEAD] * error)) return 1;
    for (int j = 0; j < n; j++) {
        reach[j] = 0.0;
        for (int i = 0; i < m; i++) reach[j] = fmax(reach[j], fabs(J[i * n + j]));
        most = fmax(most, reach[j]);
    }
    for (int j = 0; j < n; j++)
        if (reach[j] > o[C_UNMOVED] * most) step[j] += o[C_SIDE_STEP] * error * (j % 2 ? -1.0 : 1.0);
    return 1;
}

/* The same inside all limits, and the command after it. 0: left to Python. */
static int step_inside(const double *o, const Limits *l, const double *command, const double *q,
                       const double *J, const double *d, double extra, double *step, double *after) {
    const int m = (int)o[C_ROWS], n = (int)o[C_JOINTS];
    if (!safe_step(o, l, m, n, q, J, d, extra, step)) return 0;
    double square = square_of(step, n);
    if (!(square < LARGEST * LARGEST && sqrt(square) <= o[C_LONGEST])) return 0;
    for (int j = 0; j < n; j++) {
        double low = fmax(fmin(l->lower[j] - command[j], 0.0), -l->fastest[j]);
        double high = fmin(fmax(l->upper[j] - command[j], 0.0), l->fastest[j]);
        if (!(low <= step[j] && step[j] <= high)) return 0;
        after[j] = fmax(fmin(l->lower[j], command[j]), command[j] + step[j]);
        after[j] = fmin(fmax(l->upper[j], command[j]), after[j]);
    }
    return 1;
}

/* The joint step (n) of a filtered error (m). 0: left to Python. */
int fikm_step_at(const double *o, const double *command, const double *q, const double *d, double extra,
                 double *step) {
    const Limits l = limits_of(o, (int)o[C_JOINTS]);
    double J[6 * MAX_JOINTS], after[MAX_JOINTS];
    fikm_task(l.chain, (int)o[C_JOINTS], o + C_TASK, NULL, q, NULL, J);
    return step_inside(o, &l, command, q, J, d, extra, step, after);
}

/* Numbers of a target by which `remember_motion` tells how far it moves. */
static void coordinates_of(const double *t, int count, const double *target, double *x) {
    if (t[T_TURNS] == 0.0) { memcpy(x, target, sizeof(double) * (size_t)count); return; }
    const int columns = count / 3;
    for (int k = 0; k < 3; k++) for (int i = 0; i < columns; i++)
        x[k * columns + i] = target[4 * k + i] * (i < 3 ? t[T_LENGTH] / 1.41421356237309504880 : 1.0);
}

/* One cycle: command (n), velocity (n) and memory (filtered gain, filtered error (m), supervision) after
 * it, or with `out` what it computes and nothing is written: |e|, gain, filtered gain, e (m), filtered
 * error (m), joint step (n), command (n). q: measured joints (n) or NULL. 0: left to Python. */
int fikm_cycle(const double *o, double *command, double *velocity, double *memory, const double *target,
               const double *q, double *out) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const Limits l = limits_of(o, n);
    const double *t = o + C_TASK, *k = l.chain + 24 + JOINT * n, *s = k + K_COUNT;
    double error[6], J[6 * MAX_JOINTS], d[6], step[MAX_JOINTS], after[MAX_JOINTS];
    double *supervision = memory + 1 + m;
    if (!q) q = command;
    fikm_task(l.chain, n, t, target, q, error, J);
    double size = square_of(error, m);
    if (!(size < LARGEST * LARGEST)) return 0;
    size = sqrt(size);
    double gain = fikm_gain(supervision, s, size), keep = k[K_GAIN_SMOOTHING];
    double filtered = keep * memory[0] + (1.0 - keep) * gain;
    double scale = size > k[K_ERROR_LIMIT] ? filtered * k[K_ERROR_LIMIT] / size : filtered;
    keep = k[K_ERROR_SMOOTHING];
    for (int i = 0; i < m; i++) d[i] = keep * memory[1 + i] + (1.0 - keep) * (scale * error[i]);
    double extra = k[K_DAMPED] != 0.0 ? damping_of(supervision, s) : 0.0;
    if (!step_inside(o, &l, command, q, J, d, extra, step, after)) return 0;
    if (out) {
        out[0] = size, out[1] = gain, out[2] = filtered, out += 3;
        for (int i = 0; i < m; i++) out[i] = error[i], out[m + i] = d[i];
        for (int j = 0; j < n; j++) out[2 * m + j] = step[j], out[2 * m + n + j] = after[j];
        return 1;
    }
    double seen[3 + 2 * MAX_JOINTS], coordinates[MAX_TARGET], deviation[MAX_JOINTS];
    for (int j = 0; j < n; j++) deviation[j] = q[j] - command[j];
    if (fikm_remember_turns(supervision, s, error, step, seen)) {
        coordinates_of(t, (int)s[S_COORDINATES], target, coordinates);
        fikm_remember_motion(supervision, s, seen, error, coordinates,
                             k[K_MEASURED] != 0.0 ? deviation : NULL);
    }
    for (int j = 0; j < n; j++) velocity[j] = (after[j] - command[j]) * k[K_RATE], command[j] = after[j];
    memory[0] = filtered;
    memcpy(memory + 1, d, sizeof(double) * (size_t)m);
    return 1;
}
