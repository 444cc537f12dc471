/* The step of a law inside the limits of its joints: control/safe_step.py, joint_limits.py, saturation.py
 * and guard.py, which tell the mathematics. A law that Python does better there gives 0: left to Python. */
enum { C_ROWS, C_JOINTS, C_LONGEST, C_DEAD, C_SIDE_STEP, C_UNMOVED, C_WEIGHTS, C_PASSES, C_BRAKES, C_PERIOD,
       C_RESOLVES, C_GAIN, C_BRAKING_GAIN, C_HALF, C_BETTER, C_TINY, C_ROW_FLOOR, C_COLUMN_FLOOR, C_ZERO,
       C_DAMPING, C_ERROR_DAMPING, C_GROWTH, C_RETREATS, C_NEAR, C_TASK, C_LOWER = C_TASK + T_COUNT };

/* The joints' limits and what is worked out of them, (n) each, then the chain. */
typedef struct {
    const double *lower, *upper, *fastest, *change, *end_low, *end_high, *begin_low, *begin_high, *zone;
    const double *chain;
} Limits;

static Limits limits_of(const double *o, int n) {
    const double *x = o + C_LOWER;
    return (Limits){x, x + n, x + 2 * n, x + 3 * n, x + 4 * n, x + 5 * n, x + 6 * n, x + 7 * n, x + 8 * n,
                    x + 9 * n};
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
    double motion[6];
    task_motion(law, step, motion);
    for (int i = 0; i < law->m; i++) motion[i] = asked[i] - motion[i];
    return sqrt(square_of(asked, law->m)) - sqrt(square_of(motion, law->m));
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

/* `brake` of a step in place: -1: left to Python; whether it was changed. */
static int brake(const Law *law, const Limits *l, const double *error, double *step) {
    const double *o = law->o;
    const int n = law->n, m = law->m;
    double best[MAX_JOINTS], fixed[MAX_JOINTS] = {0.0}, trial[MAX_JOINTS], rest[MAX_JOINTS], more[MAX_JOINTS];
    double longest[MAX_JOINTS], asked[6], left[6], excess[MAX_JOINTS];
    int free_[MAX_JOINTS];
    copy(best, step, n);
    if (!brakeable(o, l, best, n)) return 0;
    copy(trial, step, n);
    task_motion(law, step, asked);
    double most = o[C_BRAKING_GAIN] * nearer(law, asked, best);
    for (int j = 0; j < n; j++) free_[j] = 1;
    for (int pass = 0; pass < (int)o[C_RESOLVES]; pass++) {
        double largest = 0.0, cycles = 1.0;
        int any_free = 0;
        for (int j = 0; j < n; j++) {
            longest[j] = braking(fabs(trial[j]), l->change[j]);
            excess[j] = free_[j] ? fabs(trial[j]) / (longest[j] + o[C_TINY]) : 0.0;
            largest = fmax(largest, excess[j]);
        }
        int slow[MAX_JOINTS];
        for (int j = 0; j < n; j++) {
            slow[j] = free_[j] && excess[j] >= o[C_HALF] * largest;
            free_[j] &= !slow[j], any_free |= free_[j];
        }
        if (!any_free) break;
        for (int j = 0; j < n; j++) if (free_[j]) cycles = fmax(cycles, longest[j] / l->change[j]);
        for (int j = 0; j < n; j++) {
            double longest_ = fmin(longest[j], cycles * l->change[j]);
            if (slow[j]) fixed[j] = copysign(fmin(fabs(trial[j]), longest_), trial[j]);
        }
        task_motion(law, fixed, left);
        for (int i = 0; i < m; i++) left[i] = error[i] - left[i];
        if (!solve(law, left, free_, more)) return -1;
        for (int j = 0; j < n; j++) {
            rest[j] = fixed[j] + (free_[j] ? more[j] : 0.0);
            trial[j] = free_[j] ? rest[j] : 0.0;
        }
        brakeable(o, l, trial, n);
        for (int j = 0; j < n; j++) if (!free_[j]) trial[j] = fixed[j];
        double near = nearer(law, asked, trial);
        if (near > o[C_BETTER] * most) copy(best, trial, n), most = near;
        copy(trial, rest, n);
    }
    copy(step, best, n);
    return 1;
}

/* `resolve` of a step in place, whose alternative is the step shortened to the speed of the joints. 0: left
 * to Python. */
static int resolve(const Law *law, const Limits *l, const double *error, const double *low,
                   const double *high, double gain, double *step) {
    const double *o = law->o;
    const int n = law->n, m = law->m, most = n < (int)o[C_RESOLVES] ? n : (int)o[C_RESOLVES];
    double in[MAX_JOINTS], kept[MAX_JOINTS], fixed[MAX_JOINTS] = {0.0}, trial[MAX_JOINTS], more[MAX_JOINTS];
    double asked[6], left[6], excess[MAX_JOINTS];
    int free_[MAX_JOINTS];
    copy(kept, step, n), copy(trial, step, n);
    shorten_by(kept, l->fastest, n);
    task_motion(law, step, asked);
    for (int j = 0; j < n; j++) {
        in[j] = clamped(step[j], low[j], high[j]), kept[j] = clamped(kept[j], low[j], high[j]);
        free_[j] = 1;
    }
    for (int pass = 0; pass < most; pass++) {
        double largest = 0.0;
        int any_free = 0;
        for (int j = 0; j < n; j++) {
            excess[j] = free_[j] ? fabs(trial[j] - in[j]) / (fabs(in[j]) + o[C_TINY]) : 0.0;
            largest = fmax(largest, excess[j]);
        }
        if (!(largest > 0.0)) break;
        for (int j = 0; j < n; j++) {
            if (excess[j] >= o[C_HALF] * largest) free_[j] = 0, fixed[j] = in[j];
            any_free |= free_[j];
        }
        copy(trial, fixed, n);
        if (any_free) {
            task_motion(law, fixed, left);
            for (int i = 0; i < m; i++) left[i] = error[i] - left[i];
            if (!solve(law, left, free_, more)) return 0;
            for (int j = 0; j < n; j++) if (free_[j]) trial[j] += more[j];
        }
        for (int j = 0; j < n; j++) in[j] = clamped(trial[j], low[j], high[j]);
    }
    double near = nearer(law, asked, in), other = nearer(law, asked, kept);
    copy(step, near > 0.0 && near > gain * other ? in : kept, n);
    return 1;
}

enum { LEFT, INSIDE, LIMITED };

/* `RetreatingStep.inside` while the tool is near: the law's own step where nothing is in its way. */
static int retreating_step(const double *o, const Limits *l, const double *q, double goal, const double *low,
                           const double *high, int near, double *step) {
    const int n = (int)o[C_JOINTS];
    int in = 1;
    if (goal > o[C_NEAR]) return LEFT;
    for (int j = 0; j < n; j++) {
        double fastest = fmin(l->fastest[j], 1.0 / l->zone[j]);
        double down = clamped((q[j] - l->end_low[j]) / l->zone[j], 0.0, 1.0);
        double up = clamped((l->end_high[j] - q[j]) / l->zone[j], 0.0, 1.0);
        in &= fmax(low[j], -fastest * down) <= step[j] && step[j] <= fmin(high[j], fastest * up);
    }
    if (!in && !near) return LEFT;
    return brakeable(o, l, step, n) || !in ? LIMITED : INSIDE;
}

/* `SafeStep.inside`: the law's step, near limits with weights, at a dead point aside, inside the steady
 * bounds, which a step keeps its direction of where obstacles are near. */
static int safe_step(const double *o, const Limits *l, const double *q, const double *J, const double *d,
                     double extra, const double *low, const double *high, int near, double *step) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    Law law = {o, J, NULL, extra, m, n};
    double weights[MAX_JOINTS], reach[MAX_JOINTS], error[6], most = 0.0;
    int weighted = 0;
    if (!solve(&law, d, NULL, step)) return LEFT;
    for (int j = 0; o[C_WEIGHTS] != 0.0 && j < n; j++) {
        weighted |= q[j] - l->begin_low[j] < 0.0 || l->begin_high[j] - q[j] < 0.0;
        weights[j] = 1.0;
    }
    for (int pass = 0; weighted && pass < (int)o[C_PASSES]; pass++) {
        for (int j = 0; j < n; j++) {
            double way = step[j] > 0.0 ? l->end_high[j] - q[j] : q[j] - l->end_low[j];
            if (step[j] != 0.0) weights[j] = fmin(weights[j], fmax(0.0, fmin(1.0, way / l->zone[j])));
        }
        law.weights = weights;
        if (!solve(&law, d, NULL, step)) return LEFT;
    }
    double size = sqrt(square_of(step, n)), goal = sqrt(square_of(d, m)), share = 1.0;
    int nudged = o[C_DEAD] != 0.0 && size < o[C_DEAD] * goal && size <= o[C_LONGEST], changed = nudged;
    if (!(size < LARGEST)) return LEFT;
    for (int j = 0; nudged && j < n; j++) {
        reach[j] = 0.0;
        for (int i = 0; i < m; i++) reach[j] = fmax(reach[j], fabs(J[i * n + j]));
        most = fmax(most, reach[j]);
    }
    for (int j = 0; nudged && j < n; j++)
        if (reach[j] > o[C_UNMOVED] * most) step[j] += o[C_SIDE_STEP] * goal * (j % 2 ? -1.0 : 1.0);
    changed |= sqrt(square_of(step, n)) > o[C_LONGEST];
    shorten_to(step, n, o[C_LONGEST]);
    if (o[C_RETREATS] != 0.0) return retreating_step(o, l, q, goal, low, high, near, step);
    if (near) {
        int slowed = brakeable(o, l, step, n);
        return slowed || !inside(step, low, high, n) ? LIMITED : INSIDE;
    }
    double short_ = sqrt(square_of(step, n));
    if (changed) share = short_ / fmax(fmax(size, short_), 1e-300);
    for (int i = 0; i < m; i++) error[i] = share * d[i];
    int braked = o[C_BRAKES] != 0.0 ? brake(&law, l, error, step) : 0;
    if (braked < 0) return LEFT;
    if (inside(step, low, high, n)) return braked ? LIMITED : INSIDE;
    if (braked) {
        double now = sqrt(square_of(step, n));
        share = now / fmax(fmax(short_, now), 1e-300);
        for (int i = 0; i < m; i++) error[i] *= share;
    }
    double gain = o[C_BRAKES] != 0.0 ? o[C_BRAKING_GAIN] : o[C_GAIN];
    return resolve(&law, l, error, low, high, gain, step) ? LIMITED : LEFT;
}

/* `Guard` of `asked` (n): the step. 0: left to Python, which finds out what rounding does at the length. */
static int guard(const double *o, const double *low, const double *high, const double *asked, double *step) {
    const int n = (int)o[C_JOINTS];
    double start[MAX_JOINTS], a = 0.0, b = 0.0, c = o[C_LONGEST] * o[C_LONGEST], square = square_of(asked, n);
    if (!(square < LARGEST * LARGEST)) return 0;
    for (int j = 0; j < n; j++) step[j] = clamped(asked[j], low[j], high[j]);
    square = square_of(step, n);
    if (c < INFINITY && fabs(square - c) <= 1e-12 * c) return 0;
    if (square < c) return 1;
    for (int j = 0; j < n; j++) {
        start[j] = clamped(0.0, low[j], high[j]), step[j] -= start[j];
        a += step[j] * step[j], b += start[j] * step[j], c -= start[j] * start[j];
    }
    if (!(a > 0.0 && c > 0.0)) { copy(step, start, n); return 1; }
    double root_ = sqrt(b * b + a * c), t = b > 0.0 ? c / (b + root_) : (root_ - b) / a;
    for (int j = 0; j < n; j++) step[j] = clamped(start[j] + fmin(t, 1.0) * step[j], low[j], high[j]);
    return 1;
}

/* The joint step (n) of a filtered error (m), where obstacles are near or not, before the guard. */
int fikm_step_at(const double *o, const double *command, const double *q, const double *d, double extra,
                 int near, double *step) {
    const int n = (int)o[C_JOINTS];
    const Limits l = limits_of(o, n);
    double J[6 * MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS];
    if (!(square_of(q, n) < LARGEST * LARGEST)) return LEFT;
    fikm_task(l.chain, n, o + C_TASK, NULL, q, NULL, J);
    steady_bounds(o, &l, command, low, high);
    return safe_step(o, &l, q, J, d, extra, low, high, near, step);
}
