/* The step of a law inside the limits of its joints: control/safe_step.py and guard.py, which tell the
 * mathematics. What Python does better is left to it. */

#define SURE_PIVOT 3e-3 /* of the mean square of J's rows; from here on rounding is not felt */

/* `posture_step` of a pull (n); 0: left to Python. */
static int posture_step(const Law *law, const double *pull, double *step) {
    const int n = law->n, m = law->m;
    double A[36], y[6], trace = 0.0;
    for (int i = 0; i < m; i++) {
        for (int k = 0; k < m; k++) A[i * m + k] = dot(law->J + i * n, law->J + k * n, n);
        trace += A[i * m + i];
    }
    for (int i = 0; i < m; i++) A[i * m + i] += law->o[C_POSTURE_DAMPING] * trace + 1e-300;
    if (cholesky(A, m)) return 0;
    for (int i = 0; i < m; i++) if (!(A[i * m + i] * A[i * m + i] * m > SURE_PIVOT * trace)) return 0;
    task_motion(law, pull, y);
    substitute(A, m, y);
    for (int j = 0; j < n; j++) {
        step[j] = pull[j];
        for (int i = 0; i < m; i++) step[j] -= law->J[i * n + j] * y[i];
    }
    return 1;
}

/* `SafeStep.inside`: the law's step, near limits with weights, at a dead point aside, inside the steady
 * bounds, which a step keeps its direction of where obstacles are near. */
static int safe_step(const double *o, const Limits *l, const double *q, const double *J, const double *d,
                     double extra, const double *low, const double *high, int near, double *step) {
    const int n = (int)o[C_JOINTS], m = (int)o[C_ROWS];
    Law law = {o, J, NULL, extra, m, n};
    double weights[MAX_JOINTS], reach[MAX_JOINTS], own[MAX_JOINTS], error[6], most = 0.0;
    double seen[6 * MAX_JOINTS]; /* J without the columns of joints that do not move the tool */
    double secondary[MAX_JOINTS] = {0.0}, pull[MAX_JOINTS];
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
    if (o[C_POSTURE] != 0.0) {
        for (int j = 0; j < n; j++) pull[j] = o[C_POSTURE] * (l->posture[j] - q[j]);
        if (!posture_step(&law, pull, secondary)) return LEFT;
        for (int j = 0; j < n; j++) step[j] += secondary[j];
    }
    double size = sqrt(square_of(step, n)), goal = sqrt(square_of(d, m)), share = 1.0;
    int nudged = o[C_DEAD] != 0.0 && size < o[C_DEAD] * goal && size <= o[C_LONGEST], changed = nudged;
    if (!(size < LARGEST)) return LEFT;
    copy(own, step, n);
    for (int j = 0; j < n; j++) {
        reach[j] = 0.0;
        for (int i = 0; i < m; i++) reach[j] = fmax(reach[j], fabs(J[i * n + j]));
        most = fmax(most, reach[j]);
    }
    for (int j = 0; nudged && j < n; j++)
        if (reach[j] > o[C_UNMOVED] * most) step[j] += o[C_SIDE_STEP] * goal * (j % 2 ? -1.0 : 1.0);
    changed |= sqrt(square_of(step, n)) > o[C_LONGEST];
    shorten_to(step, n, o[C_LONGEST]);
    if (o[C_RETREATS] != 0.0)
        return retreating_step(&law, l, q, d, goal, own, secondary, low, high, near, step);
    if (near) {
        int slowed = brakeable(o, l, step, n);
        return slowed || !inside(step, low, high, n) ? LIMITED : INSIDE;
    }
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) seen[i * n + j] = reach[j] > o[C_UNMOVED] * most ? J[i * n + j] : 0.0;
    law.J = seen;
    double short_ = sqrt(square_of(step, n));
    if (changed) share = short_ / fmax(fmax(size, short_), 1e-300);
    for (int i = 0; i < m; i++) error[i] = share * d[i];
    for (int j = 0; j < n; j++) secondary[j] *= share;
    int braked = o[C_BRAKES] != 0.0 ? brake(&law, l, error, secondary, step) : 0;
    if (braked < 0) return LEFT;
    if (inside(step, low, high, n)) return braked ? LIMITED : INSIDE;
    if (braked) {
        double now = sqrt(square_of(step, n));
        share = now / fmax(fmax(short_, now), 1e-300);
        for (int i = 0; i < m; i++) error[i] *= share;
        for (int j = 0; j < n; j++) secondary[j] *= share;
    }
    double gain = o[C_BRAKES] != 0.0 ? o[C_BRAKING_GAIN] : o[C_GAIN];
    return resolve(&law, l, error, secondary, low, high, gain, step) ? LIMITED : LEFT;
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
