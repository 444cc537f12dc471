/* What a step is told, a law's answer, and the limits of the joints: control/joint_limits.py. */
enum { C_ROWS, C_JOINTS, C_LONGEST, C_DEAD, C_SIDE_STEP, C_UNMOVED, C_WEIGHTS, C_PASSES, C_BRAKES, C_PERIOD,
       C_RESOLVES, C_GAIN, C_BRAKING_GAIN, C_HALF, C_BETTER, C_TINY, C_ROW_FLOOR, C_COLUMN_FLOOR, C_ZERO,
       C_DAMPING, C_ERROR_DAMPING, C_GROWTH, C_RETREATS, C_NEAR, C_STRENGTH, C_REACH, C_FAR, C_FARTHEST,
       C_STEEP, C_UNBOUNDED, C_ROUNDING, C_BLOCKS, C_BOX_PASSES, C_POSTURE,
       C_POSTURE_DAMPING, C_TASK, C_LOWER = C_TASK + T_COUNT };

/* The joints' limits and what is worked out of them, (n) each, then the chain. */
typedef struct {
    const double *lower, *upper, *fastest, *change, *end_low, *end_high, *begin_low, *begin_high, *zone;
    const double *posture, *chain;
} Limits;

static Limits limits_of(const double *o, int n) {
    const double *x = o + C_LOWER;
    return (Limits){x, x + n, x + 2 * n, x + 3 * n, x + 4 * n, x + 5 * n, x + 6 * n, x + 7 * n, x + 8 * n,
                    x + 9 * n, x + 10 * n};
}

/* What the law is asked with: its options, Jacobian (m,n), damping and weights (n) or NULL. */
typedef struct {
    const double *o, *J, *weights;
    double extra;
    int m, n;
} Law;

/* The law's step (n) for d (m), of the columns that are free; 0: left to Python. */
static int solve(const Law *law, const double *d, const int *free_, double *step) {
    const double *o = law->o, *J = law->J, *w = law->weights;
    double columns[6 * MAX_JOINTS];
    const int m = law->m, n = law->n;
    if (free_ || w) {
        for (int i = 0; i < m; i++) for (int j = 0; j < n; j++) {
            columns[i * n + j] = free_ && !free_[j] ? 0.0 : w ? J[i * n + j] * w[j] : J[i * n + j];
        }
        J = columns;
    }
    if (fikm_step(m, n, J, d, o[C_ROW_FLOOR], o[C_COLUMN_FLOOR], o[C_ZERO], o[C_DAMPING],
                  o[C_ERROR_DAMPING], law->extra, o[C_GROWTH], step)) return 0;
    for (int j = 0; w && j < n; j++) step[j] *= w[j];
    return 1;
}

/* J (m,n) x. */
static void task_motion(const Law *law, const double *x, double *motion) {
    for (int i = 0; i < law->m; i++) motion[i] = dot(law->J + i * law->n, x, law->n);
}

/* By how much a step brings the tool nearer to where `asked` (m) leads. */
static double nearer(const Law *law, const double *asked, const double *step) {
    double motion[6], rest[6], product = 0.0;
    task_motion(law, step, motion);
    for (int i = 0; i < law->m; i++) {
        rest[i] = asked[i] - motion[i];
        product += (asked[i] + rest[i]) * motion[i];
    }
    double sizes = sqrt(square_of(asked, law->m)) + sqrt(square_of(rest, law->m));
    return sizes > 0.0 ? product / sizes : 0.0;
}

static void copy(double *to, const double *from, int n) { memcpy(to, from, sizeof(double) * (size_t)n); }

static double clamped(double x, double low, double high) { return fmin(fmax(x, low), high); }

static void shorten_to(double *step, int n, double longest) {
    double size = sqrt(square_of(step, n));
    for (int j = 0; j < n && size > longest; j++) step[j] *= longest / size;
}

/* A step shortened as a whole to the longest of each joint; whether it was. */
static int shorten_by(double *step, const double *longest, int n) {
    double excess = 0.0;
    for (int j = 0; j < n; j++) excess = fmax(excess, fabs(step[j]) / fmax(longest[j], 1e-300));
    for (int j = 0; j < n && excess > 1.0; j++) step[j] /= excess;
    return excess > 1.0;
}

/* The longest step after which a stop within a distance is possible: `JointLimits.braking`. */
static double braking(double distance, double change) {
    double k = floor(0.5 * (sqrt(1.0 + 8.0 * distance / change) - 1.0));
    double step = distance / (k + 1.0) + 0.5 * k * change;
    return isfinite(step) ? step : distance;
}

static int brakeable(const double *o, const Limits *l, double *step, int n) {
    double longest[MAX_JOINTS];
    if (o[C_BRAKES] == 0.0) return 0;
    for (int j = 0; j < n; j++) longest[j] = braking(fabs(step[j]), l->change[j]);
    return shorten_by(step, longest, n);
}

/* The steps that limits of position and speed allow in this cycle: `JointLimits.steady_bounds`. */
static void steady_bounds(const double *o, const Limits *l, const double *command, double *low,
                          double *high) {
    for (int j = 0; j < (int)o[C_JOINTS]; j++) {
        low[j] = fmin(l->lower[j] - command[j], 0.0), high[j] = fmax(l->upper[j] - command[j], 0.0);
        if (o[C_BRAKES] != 0.0) {
            low[j] = -braking(-low[j], l->change[j]);
            high[j] = braking(high[j], l->change[j]);
        }
        low[j] = fmax(low[j], -l->fastest[j]), high[j] = fmin(high[j], l->fastest[j]);
    }
}

/* The same, narrowed to what acceleration allows after the last step: `changing_bounds`. */
static void changing_bounds(const double *o, const Limits *l, const double *velocity, double *low,
                            double *high) {
    for (int j = 0; o[C_BRAKES] != 0.0 && j < (int)o[C_JOINTS]; j++) {
        double last = velocity[j] * o[C_PERIOD], least = low[j], most = high[j];
        low[j] = fmin(fmax(least, last - l->change[j]), most);
        high[j] = fmax(fmin(most, last + l->change[j]), least);
    }
}

static int inside(const double *step, const double *low, const double *high, int n) {
    int in = 1;
    for (int j = 0; j < n; j++) in &= low[j] <= step[j] && step[j] <= high[j];
    return in;
}
