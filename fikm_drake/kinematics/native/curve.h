/* Curves of self-motion: the steps of solvers/self_motion/ between events, and the way to a curve. */

/* A chain of n joints, k of which move: rows (k-1,6) of a task that leaves one degree of freedom, its
 * target (three axes, a point), the n joints' positions. */
typedef struct {
    const double *chain, *rows, *target;
    const int64_t *moving;
    double *q;
    int n, k, turns;
} Curve;

enum { ITERATIONS, CONVERGED, LEAST_COSINE, LEAST_STEP, ROUNDING, SEARCH_STEPS, LONGEST, FOUND,
       SEARCH_DAMPING };

/* Errors (k-1) and Jacobian (k-1,k), its rows MAX_JOINTS long, at the moving joints' positions. */
static void linearise(const Curve *c, const double *x, double *error, double *A) {
    Frames f;
    vec q[MAX_JOINTS], J[MAX_JOINTS][6], goal[12], e[6], distance, angle;
    for (int j = 0; j < c->k; j++) c->q[c->moving[j]] = x[j];
    for (int j = 0; j < c->n; j++) q[j] = fill(c->q[j]);
    for (int i = 0; i < 12; i++) goal[i] = fill(c->target[i]);
    frames_of(c->chain, c->n, q, &f);
    jacobian_of(c->chain, c->n, &f, 1.0, J);
    for (int i = 0; i < 3; i++) e[i] = fill(0.0);
    if (c->turns) error_of(&f, goal, 1, 1.0, e, &distance, &angle);
    else error_of(&f, goal, 0, 1.0, e + 3, &distance, &angle);
    for (int i = 0; i < c->k - 1; i++) {
        const double *row = c->rows + 6 * i;
        error[i] = 0.0;
        for (int r = 0; r < 6; r++) error[i] += row[r] * e[r][0];
        for (int j = 0; j < c->k; j++) {
            double sum = 0.0;
            for (int r = 0; r < 6; r++) sum += row[r] * J[c->moving[j]][r][0];
            A[i * MAX_JOINTS + j] = sum;
        }
    }
}

/* Solve A (k,k) for two right sides, by rows exchanged for the largest pivot; the sign of det A, 0: singular. */
static int solve_two(double *A, int k, double *a, double *b) {
    int sign = 1;
    for (int p = 0; p < k; p++) {
        int best = p;
        for (int i = p + 1; i < k; i++)
            if (fabs(A[i * MAX_JOINTS + p]) > fabs(A[best * MAX_JOINTS + p])) best = i;
        if (best != p) {
            for (int j = p; j < k; j++) {
                double kept = A[p * MAX_JOINTS + j];
                A[p * MAX_JOINTS + j] = A[best * MAX_JOINTS + j], A[best * MAX_JOINTS + j] = kept;
            }
            double kept = a[p];
            a[p] = a[best], a[best] = kept;
            kept = b[p], b[p] = b[best], b[best] = kept;
            sign = -sign;
        }
        double pivot = A[p * MAX_JOINTS + p];
        if (!(fabs(pivot) > 0.0)) return 0;
        if (pivot < 0.0) sign = -sign;
        for (int i = p + 1; i < k; i++) {
            double scaled = A[i * MAX_JOINTS + p] / pivot;
            for (int j = p + 1; j < k; j++) A[i * MAX_JOINTS + j] -= scaled * A[p * MAX_JOINTS + j];
            a[i] -= scaled * a[p], b[i] -= scaled * b[p];
        }
    }
    for (int p = k - 1; p >= 0; p--) {
        for (int j = p + 1; j < k; j++)
            a[p] -= A[p * MAX_JOINTS + j] * a[j], b[p] -= A[p * MAX_JOINTS + j] * b[j];
        a[p] /= A[p * MAX_JOINTS + p], b[p] /= A[p * MAX_JOINTS + p];
    }
    return sign;
}

static double dot(const double *a, const double *b, int k) {
    double sum = 0.0;
    for (int j = 0; j < k; j++) sum += a[j] * b[j];
    return sum;
}

/* `SelfMotionCurve.solve`: from q to the point with row · q = value; 0, or the orientation, 1 or -1. */
static int newton(const Curve *c, const double *o, double *q, const double *row, double value, double *tangent) {
    double A[MAX_JOINTS * MAX_JOINTS], step[MAX_JOINTS];
    const int k = c->k;
    for (int iteration = 0; iteration < (int)o[ITERATIONS]; iteration++) {
        linearise(c, q, step, A);
        memcpy(A + (k - 1) * MAX_JOINTS, row, sizeof(double) * (size_t)k);
        step[k - 1] = value - dot(row, q, k);
        for (int j = 0; j < k; j++) tangent[j] = j == k - 1;
        int sign = solve_two(A, k, step, tangent);
        double size = 0.0;
        for (int j = 0; j < k; j++) size = fabs(step[j]) > size || step[j] != step[j] ? fabs(step[j]) : size;
        if (!sign || !(size < 1.0)) return 0;
        for (int j = 0; j < k; j++) q[j] += step[j];
        if (size < o[CONVERGED]) {
            double length = sqrt(dot(tangent, tangent, k));
            for (int j = 0; j < k; j++) tangent[j] /= length;
            return sign;
        }
    }
    return 0;
}

/* `SelfMotionCurve.advance`: the point about `step` ahead of `here`; 0: the step is too long. */
static int advance(const Curve *c, const double *o, const double *before, const double *before_tangent,
                   const double *here, const double *tangent, int orientation, double step,
                   double *there, double *there_tangent) {
    const int k = c->k;
    double guess[MAX_JOINTS], square = 0.0, miss = 0.0;
    for (int j = 0; j < k; j++) square += (here[j] - before[j]) * (here[j] - before[j]);
    for (int j = 0; j < k; j++)
        there[j] = guess[j] = here[j] + step * tangent[j] +
                              0.5 * step * step / sqrt(square) * (tangent[j] - before_tangent[j]);
    double value = dot(tangent, here, k) + step * dot(tangent, tangent, k);
    if (newton(c, o, there, tangent, value, there_tangent) != orientation) return 0;
    for (int j = 0; j < k; j++) miss += (there[j] - guess[j]) * (there[j] - guess[j]);
    return dot(there_tangent, tangent, k) >= o[LEAST_COSINE] && miss < 0.25 * step * step;
}

/* Whether a limit may be met, or a turn past one made, between two points; or the start passed. */
static int eventful(int k, double rounding, const double *walls, const double *start, const double *here,
                    const double *tangent, const double *there, const double *there_tangent) {
    const double *lower = walls, *upper = walls + k, *periodic = walls + 2 * k;
    double chord = 0.0, along = 0.0, ahead = 0.0, away = 0.0;
    for (int j = 0; j < k; j++) {
        double offset = start[j] - here[j], step = there[j] - here[j];
        if (periodic[j] != 0.0) offset -= 6.283185307179586 * rint(offset / 6.283185307179586);
        chord += step * step, ahead += tangent[j] * step;
        along += tangent[j] * offset, away += offset * offset;
    }
    if (0.0 < along && along <= ahead && away <= 2.0 * chord) return 1;
    for (int j = 0; j < k; j++) {
        if (there[j] < lower[j] - rounding || there[j] > upper[j] + rounding) return 1;
        if (tangent[j] * there_tangent[j] >= 0.0) continue;
        double excess = sqrt(chord) * fmin(fabs(tangent[j]), fabs(there_tangent[j]));
        if (tangent[j] > 0.0 ? fmax(here[j], there[j]) + excess > upper[j]
                             : fmin(here[j], there[j]) - excess < lower[j]) return 1;
    }
    return 0;
}

/* `newton`, for callers. */
int fikm_newton(const double *chain, int n, const int64_t *moving, int k, int turns, const double *rows,
                const double *target, double *positions, const double *o, double *q, const double *row,
                double value, double *tangent) {
    Curve c = {chain, rows, target, moving, positions, n, k, turns};
    return newton(&c, o, q, row, value, tangent);
}

/* Walk on from point 1 (point 0 lies before it) up to `most` points, as long as nothing happens: points
 * (most,k), tangents (most,k), walls: lower, upper, periodic (k each). Changes the step; the points known. */
int fikm_stride(const double *chain, int n, const int64_t *moving, int k, int turns, const double *rows,
                const double *target, double *positions, const double *o, int most, const double *walls,
                const double *start, int orientation, double longest, double *step, double *points,
                double *tangents) {
    Curve c = {chain, rows, target, moving, positions, n, k, turns};
    int known = 2;
    while (known < most) {
        double *here = points + (known - 1) * k, *tangent = tangents + (known - 1) * k;
        if (!advance(&c, o, here - k, tangent - k, here, tangent, orientation, *step, here + k, tangent + k)) {
            if (0.5 * *step < o[LEAST_STEP]) return known;
            *step *= 0.5;
            continue;
        }
        if (eventful(k, o[ROUNDING], walls, start, here, tangent, here + k, tangent + k)) return known;
        if (dot(tangent, tangent + k, k) > 0.99) *step = fmin(longest, 1.5 * *step);
        known++;
    }
    return known;
}

/* `arrive` up to Newton's method: damped steps from q; 0: no arrival. */
int fikm_arrive(const double *chain, int n, const int64_t *moving, int k, int turns, const double *rows,
                const double *target, double *positions, const double *o, double *q) {
    Curve c = {chain, rows, target, moving, positions, n, k, turns};
    double A[MAX_JOINTS * MAX_JOINTS], M[MAX_JOINTS * MAX_JOINTS], error[MAX_JOINTS], y[MAX_JOINTS];
    for (int i = 0; i < (int)o[SEARCH_STEPS]; i++) {
        linearise(&c, q, error, A);
        double square = dot(error, error, k - 1), length = 0.0;
        if (square < o[FOUND] * o[FOUND]) return 1;
        for (int a = 0; a < k - 1; a++) {
            y[a] = 0.0;
            for (int b = 0; b < k - 1; b++)
                M[a * MAX_JOINTS + b] = dot(A + a * MAX_JOINTS, A + b * MAX_JOINTS, k) +
                                        (a == b ? o[SEARCH_DAMPING] * square : 0.0);
        }
        if (!solve_two(M, k - 1, error, y)) return 0;
        for (int j = 0; j < k; j++) {
            y[j] = 0.0;
            for (int a = 0; a < k - 1; a++) y[j] += error[a] * A[a * MAX_JOINTS + j];
            length += y[j] * y[j];
        }
        double share = fmin(1.0, o[LONGEST] / sqrt(length));
        for (int j = 0; j < k; j++) q[j] += share * y[j];
    }
    return 0;
}
