/* Joints draw back from their limits: control/limit_retreat.py, retreating_step.py, box_step.py and
 * laws/quadratic.py, which tell the mathematics. */
enum { LEFT, INSIDE, LIMITED };
#define SURE_ERROR 1e6 /* of the reach; beyond it rounding alone moves joints */
#define SURE_DAMPING 1e-4 /* squared; from here on rounding is not felt */

/* ½ xᵀ H x − gᵀ x that a law minimises, and its metric of the joints. */
typedef struct {
    double H[MAX_JOINTS * MAX_JOINTS], g[MAX_JOINTS], columns[MAX_JOINTS];
} Quadratic;

/* `_raised`, in place; who is zero. */
static void raise_sums(double *sums, int count, double floor_, double zero, int *none) {
    double most = 0.0;
    for (int i = 0; i < count; i++) most = fmax(most, sums[i]);
    for (int i = 0; i < count; i++) {
        double raised = hypot(sums[i], floor_ * most);
        none[i] = raised <= zero * most;
        sums[i] = !none[i] ? raised : most > 0.0 ? most : 1.0;
    }
}

/* `quadratic_of`; 0: left to Python. */
static int quadratic_of(const Law *law, const double *d, Quadratic *a) {
    const double *o = law->o;
    const int n = law->n, m = law->m, once = o[C_GROWTH] == 0.0;
    double J[6 * MAX_JOINTS], rows[6] = {0.0}, turn[6], square = 0.0;
    int no_row[6], no_column[MAX_JOINTS];
    memset(a->H, 0, sizeof(double) * (size_t)(n * n));
    for (int j = 0; j < n; j++) a->columns[j] = a->g[j] = 0.0;
    for (int i = 0; i < m; i++) for (int j = 0; j < n; j++) {
        double size = fabs(law->J[i * n + j]);
        rows[i] += size, a->columns[j] += size;
    }
    raise_sums(rows, m, once ? hypot(o[C_ROW_FLOOR], law->extra) : o[C_ROW_FLOOR], o[C_ZERO], no_row);
    raise_sums(a->columns, n, o[C_COLUMN_FLOOR], o[C_ZERO], no_column);
    for (int i = 0; i < m; i++) {
        turn[i] = d[i] / rows[i], square += turn[i] * turn[i];
        for (int j = 0; j < n; j++) {
            J[i * n + j] = no_row[i] || no_column[j] ? 0.0 : law->J[i * n + j];
            a->g[j] += turn[i] * J[i * n + j];
        }
    }
    double far = fmin(o[C_ERROR_DAMPING] * sqrt(square), MOST_ERROR_DAMPING);
    square = once ? 1.0 : o[C_DAMPING] * o[C_DAMPING] + law->extra * law->extra + far * far;
    if (!(square >= SURE_DAMPING)) return 0;
    for (int i = 0; i < m && !once; i++) for (int j = 0; j < n; j++) for (int k = 0; k < n; k++)
        a->H[j * n + k] += J[i * n + j] / rows[i] * J[i * n + k];
    for (int j = 0; j < n; j++) a->H[j * n + j] += square * a->columns[j];
    return 1;
}

/* `least_in_box`; 0: left to Python. */
static int least_in_box(const double *o, int n, const double *H, const double *g, const double *low,
                        const double *high, double *x) {
    double A[MAX_JOINTS * MAX_JOINTS], y[MAX_JOINTS];
    int side[MAX_JOINTS] = {0}, place[MAX_JOINTS], wrong[MAX_JOINTS], below[MAX_JOINTS], fewest = n + 1;
    int patience = (int)o[C_BLOCKS];
    for (int pass = 0; pass < (int)o[C_BOX_PASSES] * n; pass++) {
        int64_t k = 0;
        int count = 0, last = 0;
        for (int j = 0; j < n; j++) {
            x[j] = side[j] < 0 ? low[j] : side[j] > 0 ? high[j] : 0.0;
            if (!side[j]) place[k++] = j;
        }
        for (int i = 0; i < k; i++) {
            y[i] = g[place[i]] - dot(H + place[i] * n, x, n);
            for (int j = 0; j < k; j++) A[i * k + j] = H[place[i] * n + place[j]];
        }
        if (k) {
            if (cholesky(A, k)) return 0;
            substitute(A, k, y);
        }
        for (int i = 0; i < k; i++) x[place[i]] = y[i];
        if (!(square_of(x, n) < LARGEST * LARGEST)) return 0;
        for (int j = 0; j < n; j++) {
            double slack = o[C_ROUNDING] * (high[j] - low[j]), pull = g[j] - dot(H + j * n, x, n);
            below[j] = x[j] < low[j] - slack;
            wrong[j] = side[j] ? side[j] * pull < 0.0 && low[j] < high[j]
                               : below[j] || x[j] > high[j] + slack;
            if (wrong[j]) count++, last = j;
        }
        if (!count) break;
        if (count < fewest) fewest = count, patience = (int)o[C_BLOCKS];
        else patience--;
        for (int j = 0; j < n; j++)
            if (wrong[j] && (patience >= 0 || j == last)) side[j] = side[j] ? 0 : below[j] ? -1 : 1;
    }
    for (int j = 0; j < n; j++) x[j] = clamped(x[j], low[j], high[j]);
    return 1;
}

/* `RetreatingStep.inside` of an error (m) of length `goal`: `own` (n) is the law's step with the null-space
 * motion `secondary` (n), `step` the same short and aside. */
static int retreating_step(const Law *law, const Limits *l, const double *q, const double *d, double goal,
                           const double *own, const double *secondary, const double *low, const double *high,
                           int near, double *step) {
    const double *o = law->o, *middle = l->begin_low, *half = l->begin_high;
    const int n = law->n;
    Quadratic a;
    double least[MAX_JOINTS], most[MAX_JOINTS], wide[MAX_JOINTS], narrow[MAX_JOINTS], added[MAX_JOINTS];
    for (int j = 0; j < n; j++) {
        double fastest = fmin(l->fastest[j], 1.0 / l->zone[j]);
        double down = clamped((q[j] - l->end_low[j]) / l->zone[j], 0.0, 1.0);
        double up = clamped((l->end_high[j] - q[j]) / l->zone[j], 0.0, 1.0);
        least[j] = fmax(low[j], -fastest * down), most[j] = fmin(high[j], fastest * up);
        narrow[j] = -o[C_UNBOUNDED], wide[j] = o[C_UNBOUNDED], added[j] = secondary[j];
    }
    int in = inside(step, least, most, n);
    if (goal <= o[C_NEAR] && (in || near)) return brakeable(o, l, step, n) || !in ? LIMITED : INSIDE;
    if (!(goal < SURE_ERROR * o[C_REACH]) || !quadratic_of(law, d, &a)) return LEFT;
    double size = sqrt(square_of(own, n));
    int dead = size < o[C_DEAD] * goal && size <= o[C_LONGEST];
    for (int j = 0; j < n && dead; j++) added[j] += step[j] - own[j];
    for (int j = 0; j < n; j++) a.g[j] += dot(a.H + j * n, added, n);
    if (goal > o[C_NEAR]) {
        double share = (fmin(goal / o[C_REACH], o[C_FARTHEST]) - o[C_FAR]) / (o[C_FARTHEST] - o[C_FAR]);
        for (int j = 0; j < n; j++) {
            double way = middle[j] - q[j], steep = pow(fabs(way / half[j]), o[C_STEEP]);
            double pull = o[C_STRENGTH] * share * share * a.columns[j] * steep;
            a.g[j] += pull * way, a.H[j * n + j] += pull;
        }
    }
    if (!least_in_box(o, n, a.H, a.g, near ? narrow : least, near ? wide : most, step)) return LEFT;
    double part = o[C_LONGEST] / fmax(sqrt(square_of(step, n)), 1e-300);
    for (int j = 0; j < n && part < 1.0; j++) step[j] *= part;
    brakeable(o, l, step, n);
    for (int j = 0; j < n; j++) if (step[j] <= least[j] || step[j] >= most[j]) return LIMITED;
    return INSIDE;
}
