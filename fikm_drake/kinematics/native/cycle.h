/* A control cycle as `control/cycle.py` tells it, as long as nothing out of the ordinary happens in it.
 *
 * What is out of the ordinary (an input that is not finite, a step that a limit takes a part of, equations
 * that are nearly singular) is left to Python: then nothing has been written.
 */
enum { C_ROWS, C_JOINTS, C_LONGEST, C_SURE, C_DEAD, C_SIDE_STEP, C_UNMOVED, C_WEIGHTS, C_PASSES, C_ROW_FLOOR,
       C_COLUMN_FLOOR, C_ZERO, C_DAMPING, C_ERROR_DAMPING, C_GROWTH, C_TASK, C_LOWER = C_TASK + T_COUNT };
/* Then eight vectors of `Limits`, the chain, and for a whole cycle these, the supervisor's, the search's. */
enum { K_ERROR_LIMIT, K_GAIN_SMOOTHING, K_ERROR_SMOOTHING, K_RATE, K_MEASURED, K_DAMPED, K_COUNT };

/* The joints' limits and what is worked out of them, (n) each, then the chain. */
typedef struct {
    const double *lower, *upper, *fastest, *end_low, *end_high, *begin_low, *begin_high, *zone, *chain;
} Limits;

static Limits limits_of(const double *o, int n) {
    const double *x = o + C_LOWER;
    return (Limits){x, x + n, x + 2 * n, x + 3 * n, x + 4 * n, x + 5 * n, x + 6 * n, x + 7 * n, x + 8 * n};
}

static int law(const double *o, int m, int n, const double *J, const double *d, double extra, double *step) {
    return fikm_step(m, n, J, d, o[C_ROW_FLOOR], o[C_COLUMN_FLOOR], o[C_ZERO], o[C_DAMPING],
                     o[C_ERROR_DAMPING], extra, o[C_GROWTH], step);
}

static void shorten_to(double *step, int n, double longest) {
    double size = sqrt(square_of(step, n));
    for (int j = 0; j < n && size > longest; j++) step[j] *= longest / size;
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
    if (!(size < LARGEST)) return 0;
    shorten_to(step, n, o[C_LONGEST]);
    if (size > o[C_LONGEST] || o[C_DEAD] == 0.0 || !(size < o[C_DEAD] * error)) return 1;
    for (int j = 0; j < n; j++) {
        reach[j] = 0.0;
        for (int i = 0; i < m; i++) reach[j] = fmax(reach[j], fabs(J[i * n + j]));
        most = fmax(most, reach[j]);
    }
    for (int j = 0; j < n; j++)
        if (reach[j] > o[C_UNMOVED] * most) step[j] += o[C_SIDE_STEP] * error * (j % 2 ? -1.0 : 1.0);
    shorten_to(step, n, o[C_LONGEST]);
    return 1;
}

/* The steps that limits allow in this cycle: `JointLimits.steady_bounds`. */
static void bounds_of(const Limits *l, int n, const double *command, double *low, double *high) {
    for (int j = 0; j < n; j++) {
        low[j] = fmax(fmin(l->lower[j] - command[j], 0.0), -l->fastest[j]);
        high[j] = fmin(fmax(l->upper[j] - command[j], 0.0), l->fastest[j]);
    }
}

static int inside(const double *step, const double *low, const double *high, int n) {
    int in = 1;
    for (int j = 0; j < n; j++) in &= low[j] <= step[j] && step[j] <= high[j];
    return in;
}

/* The joint step (n) of a filtered error (m). 0: left to Python. */
int fikm_step_at(const double *o, const double *command, const double *q, const double *d, double extra,
                 double *step) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const Limits l = limits_of(o, n);
    double J[6 * MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS];
    fikm_task(l.chain, n, o + C_TASK, NULL, q, NULL, J);
    bounds_of(&l, n, command, low, high);
    return safe_step(o, &l, m, n, q, J, d, extra, step) && inside(step, low, high, n);
}

/* What a cycle computes, as native_cycle.py reads it: all of doubles. `limited`: of the law's step. */
typedef struct {
    double size, gain, filtered, limited, error[6], filtered_error[6], asked[MAX_JOINTS], step[MAX_JOINTS];
    double after[MAX_JOINTS], J[6 * MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS];
} Cycle;

int64_t fikm_cycle_size(void) { return sizeof(Cycle) / sizeof(double); }

/* The error, the gain and the joint step, which is that of `way` (n) where a restart search drives. Limits
 * may take a part of the law's away only if obstacles are near. 0: left to Python. */
static int ask(const double *o, const Limits *l, const double *command, const double *memory,
               const double *target, const double *q, const double *way, int near, Cycle *c) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const double *k = l->chain + 24 + JOINT * n, *s = k + K_COUNT, *supervision = memory + 1 + m;
    double keep = k[K_GAIN_SMOOTHING];
    fikm_task(l->chain, n, o + C_TASK, target, q, c->error, c->J);
    c->size = square_of(c->error, m);
    if (!(c->size < LARGEST * LARGEST)) return 0;
    c->size = sqrt(c->size);
    c->gain = fikm_gain(supervision, s, c->size);
    c->filtered = keep * memory[0] + (1.0 - keep) * c->gain;
    double scale = c->size > k[K_ERROR_LIMIT] ? c->filtered * k[K_ERROR_LIMIT] / c->size : c->filtered;
    keep = k[K_ERROR_SMOOTHING];
    for (int i = 0; i < m; i++)
        c->filtered_error[i] = keep * memory[1 + i] + (1.0 - keep) * (scale * c->error[i]);
    double extra = k[K_DAMPED] != 0.0 ? damping_of(supervision, s) : 0.0;
    bounds_of(l, n, command, c->low, c->high);
    if (!safe_step(o, l, m, n, q, c->J, c->filtered_error, extra, c->asked)) return 0;
    c->limited = !inside(c->asked, c->low, c->high, n);
    if (way) memcpy(c->asked, way, sizeof(double) * (size_t)n);
    return near || way || c->limited == 0.0;
}

/* `Guard`, as far as the step is not too long, and the command after it. 0: left to Python. */
static int guard(const double *o, const Limits *l, const double *command, Cycle *c) {
    const int n = (int)o[C_JOINTS];
    double square = square_of(c->asked, n);
    if (!(square < LARGEST * LARGEST)) return 0;
    for (int j = 0; j < n; j++) {
        c->step[j] = fmin(fmax(c->asked[j], c->low[j]), c->high[j]);
        c->after[j] = fmax(fmin(l->lower[j], command[j]), command[j] + c->step[j]);
        c->after[j] = fmin(fmax(l->upper[j], command[j]), c->after[j]);
    }
    return sqrt(square_of(c->step, n)) <= o[C_LONGEST] * o[C_SURE];
}

/* Write a cycle into the state. 2: the restart search is left to Python. */
static int remember(const double *o, const Limits *l, double *command, double *velocity, double *memory,
                    const double *target, const double *q, const Cycle *c) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const double *t = o + C_TASK, *k = l->chain + 24 + JOINT * n, *s = k + K_COUNT, *r = s + S_COUNT;
    double *supervision = memory + 1 + m, *search = memory + (int)r[R_PLACE];
    double seen[3 + 2 * MAX_JOINTS], coordinates[MAX_TARGET], deviation[MAX_JOINTS];
    int done = r[R_PLACE] == 0.0 || watch(r, l->chain, n, t, search, target, q, c->size) ? 1 : 2;
    for (int j = 0; j < n; j++) deviation[j] = q[j] - command[j];
    if (fikm_remember_turns(supervision, s, c->error, c->step, seen)) {
        coordinates_of(t, (int)s[S_COORDINATES], target, coordinates);
        fikm_remember_motion(supervision, s, seen, c->error, coordinates,
                             k[K_MEASURED] != 0.0 ? deviation : NULL);
    }
    for (int j = 0; j < n; j++)
        velocity[j] = (c->after[j] - command[j]) * k[K_RATE], command[j] = c->after[j];
    memory[0] = c->filtered;
    memcpy(memory + 1, c->filtered_error, sizeof(double) * (size_t)m);
    return done;
}

/* One cycle: command (n), velocity (n) and memory (filtered gain, filtered error (m), supervision, restart
 * search) after it, or with `peek` only what it computes. q: joints (n), the command or measured; way: the
 * step (n) of a restart search, or NULL. 0: left to Python; 2: of it the restart search. */
int fikm_cycle(const double *o, double *command, double *velocity, double *memory, const double *target,
               const double *q, const double *way, int peek, Cycle *c) {
    const Limits l = limits_of(o, (int)o[C_JOINTS]);
    if (!ask(o, &l, command, memory, target, q, way, 0, c) || !guard(o, &l, command, c)) return 0;
    return peek ? 1 : remember(o, &l, command, velocity, memory, target, q, c);
}

/* The same among obstacles, in two calls. First what is asked for, cleared of the raw pairs in `clear`: an
 * answer of `fikm_clear`, where ends of steps may have to be looked at. Then the cycle with what is left. */
int fikm_ask_clear(const double *o, const double *command, const double *velocity, const double *memory,
                   const double *target, const double *q, const double *way, Clear *clear, Cycle *c) {
    (void)velocity;
    const size_t n = (size_t)o[C_JOINTS], m = (size_t)o[C_ROWS];
    const Limits l = limits_of(o, (int)n);
    if (fikm_clear(clear, TAKE) != CLEARED) return TO_NUMPY;
    if (!ask(o, &l, command, memory, target, q, way, clear->near > 0, c)) return TO_NUMPY;
    memcpy(clear->step, c->asked, sizeof(double) * n);
    memcpy(clear->low, c->low, sizeof(double) * n);
    memcpy(clear->high, c->high, sizeof(double) * n);
    memcpy(clear->J, c->J, sizeof(double) * m * n);
    clear->m = (int64_t)m, clear->bounded = 1;
    return fikm_clear(clear, BEGIN);
}

int fikm_cycle_clear(const double *o, double *command, double *velocity, double *memory,
                     const double *target, const double *q, const Clear *clear, int peek, Cycle *c) {
    const Limits l = limits_of(o, (int)o[C_JOINTS]);
    memcpy(c->asked, clear->taken, sizeof(double) * (size_t)o[C_JOINTS]);
    if (!guard(o, &l, command, c)) return 0;
    return peek ? 1 : remember(o, &l, command, velocity, memory, target, q, c);
}
