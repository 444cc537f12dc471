/* A control cycle as `control/cycle.py` tells it, as long as nothing out of the ordinary happens in it.
 *
 * What is out of the ordinary (an input that is not finite, equations that are nearly singular) is left to
 * Python: then nothing has been written.
 */
/* Behind what limits.h is told: of a whole cycle these, then the supervisor's, the search's. */
enum { K_ERROR_LIMIT, K_GAIN_SMOOTHING, K_ERROR_SMOOTHING, K_RATE, K_MEASURED, K_DAMPED, K_COUNT };

/* What a cycle computes, as native_cycle.py reads it: all of doubles. `limited`: of the law's step. */
typedef struct {
    double size, gain, filtered, limited, error[6], filtered_error[6], asked[MAX_JOINTS], step[MAX_JOINTS];
    double after[MAX_JOINTS], J[6 * MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS];
} Cycle;

int64_t fikm_cycle_size(void) { return sizeof(Cycle) / sizeof(double); }

/* The error, the gain and the joint step, which is that to `posture` (n) where a restart search drives. 0:
 * left to Python. */
static int ask(const double *o, const Limits *l, const double *command, const double *velocity,
               const double *memory, const double *target, const double *q, const double *posture, int near,
               Cycle *c) {
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
    steady_bounds(o, l, command, c->low, c->high);
    const int as_it_is = near || (posture && o[C_RETREATS] == 0.0); /* then only `limited` counts */
    int answer = safe_step(o, l, q, c->J, c->filtered_error, extra, c->low, c->high, as_it_is, c->asked);
    if (answer == LEFT) return 0;
    c->limited = answer == LIMITED;
    if (posture) drive(s + S_COUNT, o, l, posture, q, c->asked);
    changing_bounds(o, l, velocity, c->low, c->high);
    return 1;
}

/* The step that the guard lets through, and the command after it. 0: left to Python. */
static int let_through(const double *o, const Limits *l, const double *command, Cycle *c) {
    if (!guard(o, c->low, c->high, c->asked, c->step)) return 0;
    for (int j = 0; j < (int)o[C_JOINTS]; j++)
        c->after[j] = clamped(command[j] + c->step[j], fmin(l->lower[j], command[j]),
                              fmax(l->upper[j], command[j]));
    return 1;
}

enum { UNDONE, DONE, SEARCH_LEFT, POSTURE_PASSED };

/* Write a cycle into the state. */
static int remember(const double *o, const Limits *l, double *command, double *velocity, double *memory,
                    const double *target, const double *q, const double *posture, const Cycle *c) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    const double *t = o + C_TASK, *k = l->chain + 24 + JOINT * n, *s = k + K_COUNT, *r = s + S_COUNT;
    double *supervision = memory + 1 + m, *search = memory + (int)r[R_PLACE];
    double seen[3 + 2 * MAX_JOINTS], coordinates[MAX_TARGET], deviation[MAX_JOINTS];
    int done = DONE;
    if (r[R_PLACE] != 0.0 && posture) {
        if (arrive(r, l->chain, n, t, search, target, posture, q)) done = POSTURE_PASSED;
    } else if (r[R_PLACE] != 0.0 && !watch(r, l->chain, n, t, search, target, q, c->size)) done = SEARCH_LEFT;
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
 * search) after it, or with `peek` only what it computes. q: joints (n), the command or measured;
 * posture: to which a restart search drives (n), or NULL. */
int fikm_cycle(const double *o, double *command, double *velocity, double *memory, const double *target,
               const double *q, const double *posture, int peek, Cycle *c) {
    const Limits l = limits_of(o, (int)o[C_JOINTS]);
    if (!ask(o, &l, command, velocity, memory, target, q, posture, 0, c)) return 0;
    if (!let_through(o, &l, command, c)) return 0;
    return peek ? 1 : remember(o, &l, command, velocity, memory, target, q, posture, c);
}

/* The same among obstacles, in two calls. First what is asked for, cleared of the raw pairs in `clear`: an
 * answer of `fikm_clear`, where ends of steps may have to be looked at. Then the cycle with what is left. */
int fikm_ask_clear(const double *o, const double *command, const double *velocity, const double *memory,
                   const double *target, const double *q, const double *posture, Clear *clear, Cycle *c) {
    const size_t n = (size_t)o[C_JOINTS], m = (size_t)o[C_ROWS];
    const Limits l = limits_of(o, (int)n);
    if (fikm_clear(clear, TAKE) != CLEARED) return TO_NUMPY;
    if (!ask(o, &l, command, velocity, memory, target, q, posture, clear->near > 0, c)) return TO_NUMPY;
    memcpy(clear->step, c->asked, sizeof(double) * n);
    memcpy(clear->low, c->low, sizeof(double) * n);
    memcpy(clear->high, c->high, sizeof(double) * n);
    memcpy(clear->J, c->J, sizeof(double) * m * n);
    clear->m = (int64_t)m, clear->bounded = 1;
    return fikm_clear(clear, BEGIN);
}

int fikm_cycle_clear(const double *o, double *command, double *velocity, double *memory,
                     const double *target, const double *q, const double *posture, const Clear *clear,
                     int peek, Cycle *c) {
    const Limits l = limits_of(o, (int)o[C_JOINTS]);
    memcpy(c->asked, clear->taken, sizeof(double) * (size_t)o[C_JOINTS]);
    if (!let_through(o, &l, command, c)) return 0;
    return peek ? 1 : remember(o, &l, command, velocity, memory, target, q, posture, c);
}
