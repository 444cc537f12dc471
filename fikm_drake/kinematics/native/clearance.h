/* The step that keeps clear of near pairs: the arithmetic of control/clear_step.py and
 * control/row_projection.py, which tell the mathematics; native_clearance.py is the caller. */

enum { NEAR_PAIRS = 96, ROWS = 2 * NEAR_PAIRS + 2 * MAX_JOINTS, ROUNDS = 24, MOST_TASK_ROWS = 6 };
enum { CLEARED, WANT_BOUNDS, WANT_LOOK, TO_NUMPY };
enum { TAKE, BEGIN, GO_ON, LOOKED, FINISH };

/* Mirrored field by field in native_clearance.py; all fields are of 8 bytes. */
typedef struct {
    const double *first, *second, *rates;
    int64_t first_knots, second_knots, n, positions, columns[MAX_JOINTS];
    double safe, zone, period, retreat, tolerance, least_share, loss, free, soft, tiny, unfelt, blocking;
    double nothing, something, reach[MAX_JOINTS];
    /* of a cycle; raw: derivatives (positions,k) of the distances by all positions */
    int64_t m, k, bounded, moves, padded, correct;
    double step[MAX_JOINTS], low[MAX_JOINTS], high[MAX_JOINTS], J[MOST_TASK_ROWS * MAX_JOINTS];
    double raw_distances[NEAR_PAIRS], raw[NEAR_PAIRS * MAX_JOINTS], moved[NEAR_PAIRS];
    /* found */
    double taken[MAX_JOINTS], distance;
    int64_t blocked, row;
    /* between two calls */
    int64_t near, looked, felt[NEAR_PAIRS];
    double distances[2 * NEAR_PAIRS], rows[2 * NEAR_PAIRS * MAX_JOINTS], ways[2 * NEAR_PAIRS * MAX_JOINTS];
    double least[ROWS], M[MAX_JOINTS * MAX_JOINTS], pushes[ROWS], asked[MAX_JOINTS];
} Clear;

int64_t fikm_clear_size(void) { return sizeof(Clear); }

/* Rows: those of near pairs, then the least and the greatest step of each joint, then looked-at ones. */
static int64_t pair_of(const Clear *c, int64_t i) {
    return i < c->near ? i : i >= c->near + 2 * c->n ? i - 2 * c->n : -1;
}

static double along(const Clear *c, int64_t i, const double *x) {
    int64_t pair = pair_of(c, i);
    if (pair >= 0) return dot(c->rows + pair * c->n, x, c->n);
    return i < c->near + c->n ? x[i - c->near] : -x[i - c->near - c->n];
}

/* Element j of M times a row. */
static double way(const Clear *c, int64_t i, int64_t j) {
    int64_t pair = pair_of(c, i), n = c->n;
    if (pair >= 0) return c->ways[pair * n + j];
    return i < c->near + n ? c->M[j * n + i - c->near] : -c->M[j * n + i - c->near - n];
}

/* Raw pairs that the joints feel, behind those that are there; -1: numpy has to see them. */
static int64_t take(Clear *c, int64_t behind) {
    int64_t count = 0, n = c->n;
    for (int64_t i = 0; i < c->k; i++) {
        double *row = c->rows + (behind + count) * n, square = 0.0;
        for (int64_t j = 0; j < n; j++) {
            row[j] = c->raw[c->columns[j] * c->k + i];
            square += row[j] * row[j];
        }
        if (!(square > c->unfelt && square < INFINITY)) continue;
        if (c->padded && c->raw_distances[i] < 0.0) return -1;
        c->distances[behind + count] = c->raw_distances[i];
        if (!behind) c->felt[count] = i;
        count++;
    }
    return count;
}

static double nearest(const double *distances, int64_t k) {
    double least = INFINITY;
    for (int64_t i = 0; i < k; i++) least = fmin(least, distances[i]);
    return least;
}

static void ways_of(Clear *c, int64_t from, int64_t to) {
    for (int64_t i = from; i < to; i++)
        for (int64_t j = 0; j < c->n; j++) c->ways[i * c->n + j] = dot(c->M + j * c->n, c->rows + i * c->n, c->n);
}

/* L (k,k) of the positive A = L Lᵀ, in place; 1: it is not. */
static int cholesky(double *A, int64_t k) {
    for (int64_t j = 0; j < k; j++) {
        double *row = A + j * k, pivot = row[j] - dot(row, row, j);
        if (!(pivot > 0.0)) return 1;
        row[j] = sqrt(pivot);
        for (int64_t i = j + 1; i < k; i++) A[i * k + j] = (A[i * k + j] - dot(A + i * k, row, j)) / row[j];
    }
    return 0;
}

static void substitute(const double *L, int64_t k, double *x) {
    for (int64_t i = 0; i < k; i++) x[i] = (x[i] - dot(L + i * k, x, i)) / L[i * k + i];
    for (int64_t i = k - 1; i >= 0; i--) {
        for (int64_t j = i + 1; j < k; j++) x[i] -= L[j * k + i] * x[j];
        x[i] /= L[i * k + i];
    }
}

/* `task_metric`. */
static int metric(Clear *c) {
    int64_t n = c->n, m = c->m;
    double A[MOST_TASK_ROWS * MOST_TASK_ROWS], x[MOST_TASK_ROWS], trace = 0.0;
    for (int64_t i = 0; i < m; i++)
        for (int64_t k = 0; k < m; k++) A[i * m + k] = dot(c->J + i * n, c->J + k * n, n);
    for (int64_t i = 0; i < m; i++) trace += A[i * m + i];
    for (int64_t i = 0; i < m; i++) A[i * m + i] += c->free * fmax(trace, 1e-300) / m;
    if (m && cholesky(A, m)) return 1;
    for (int64_t j = 0; j < n; j++) {
        for (int64_t i = 0; i < m; i++) x[i] = c->J[i * n + j];
        substitute(A, m, x);
        for (int64_t k = 0; k < n; k++) {
            double sum = k == j;
            for (int64_t i = 0; i < m; i++) sum -= c->J[i * n + k] * x[i];
            c->M[k * n + j] = sum;
        }
    }
    return 0;
}

/* `_solve`: drops active rows that pull. */
static int solve_active(const Clear *c, int64_t *active, int64_t *count, const double *slack, double *push) {
    double gram[ROUNDS * ROUNDS], L[ROUNDS * ROUNDS], rest[ROUNDS];
    for (;;) {
        int64_t k = *count, least = 0;
        for (int64_t i = 0; i < k; i++)
            for (int64_t l = 0; l <= i; l++) {
                double x[MAX_JOINTS];
                for (int64_t j = 0; j < c->n; j++) x[j] = way(c, active[l], j);
                L[i * k + l] = gram[i * k + l] = gram[l * k + i] = along(c, active[i], x);
                if (i == l) L[i * k + i] *= 1.0 + c->soft;
            }
        if (cholesky(L, k)) return 1;
        for (int64_t i = 0; i < k; i++) push[i] = -slack[active[i]];
        substitute(L, k, push);
        for (int64_t i = 0; i < k; i++) rest[i] = -slack[active[i]] - dot(gram + i * k, push, k);
        substitute(L, k, rest);
        for (int64_t i = 0; i < k; i++) {
            push[i] += rest[i];
            if (push[i] < push[least]) least = i;
        }
        if (push[least] >= 0.0) return 0;
        for (int64_t i = least; i + 1 < k; i++) active[i] = active[i + 1];
        *count = k - 1;
    }
}

/* `project` of `taken`, in place. */
static int project_rows(Clear *c, double tolerance) {
    int64_t n = c->n, count = c->near + 2 * n + c->looked, active[ROUNDS], k = 0;
    double asked[ROWS], slack[ROWS], sizes[ROWS], push[ROUNDS], start[MAX_JOINTS];
    double least = INFINITY, most = 0.0, longest = 0.0;
    memcpy(start, c->taken, sizeof start);
    memset(c->pushes, 0, sizeof c->pushes);
    for (int64_t i = 0; i < count; i++) {
        slack[i] = asked[i] = along(c, i, start) - c->least[i];
        if (!isfinite(asked[i])) { sizes[i] = INFINITY; continue; }
        double x[MAX_JOINTS];
        for (int64_t j = 0; j < n; j++) x[j] = way(c, i, j);
        sizes[i] = sqrt(along(c, i, x));
        longest = fmax(longest, sizes[i]), most = fmax(most, fabs(asked[i])), least = fmin(least, asked[i]);
    }
    if (least >= -tolerance) return 0;
    tolerance = fmax(tolerance, 1e-12 * most);
    for (int round = 0; round < ROUNDS; round++) {
        int64_t worst = -1, known = 0;
        double deepest = 0.0;
        for (int64_t i = 0; i < count; i++) {
            if (sizes[i] == INFINITY || sizes[i] <= c->tiny * longest) continue;
            double depth = (slack[i] + tolerance) / sizes[i];
            if (depth < deepest) deepest = depth, worst = i;
        }
        for (int64_t i = 0; i < k; i++) known |= active[i] == worst;
        if (worst < 0 || known) break;
        active[k++] = worst;
        if (solve_active(c, active, &k, asked, push)) return 1;
        for (int64_t j = 0; j < n; j++) {
            c->taken[j] = start[j];
            for (int64_t i = 0; i < k; i++) c->taken[j] += push[i] * way(c, active[i], j);
        }
        for (int64_t i = 0; i < count; i++)
            if (isfinite(asked[i])) slack[i] = along(c, i, c->taken) - c->least[i];
    }
    for (int64_t i = 0; i < k; i++) c->pushes[active[i]] = push[i];
    return 0;
}

static int64_t place(const double *knots, int64_t count, double x, double *fraction) {
    int64_t i = 0;
    while (i + 2 < count && knots[i + 1] <= x) i++;
    *fraction = fmin(fmax((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0), 1.0);
    return i;
}

/* What a distance must at least change by: `_least_changes`. */
static double least_change(const Clear *c, double gap, double change) {
    double f, g, approach = fmax(-change, 0.0) / (c->zone * c->period);
    int64_t i = place(c->first, c->first_knots, gap / c->zone, &f);
    int64_t j = place(c->second, c->second_knots, approach, &g), stride = c->second_knots;
    const double *w = c->rates + i * stride + j;
    double rate = (1.0 - f) * ((1.0 - g) * w[0] + g * w[1]) +
                  f * ((1.0 - g) * w[stride] + g * w[stride + 1]);
    return fmin(-(1.0 - exp(-rate * c->period)) * gap, c->retreat * c->period);
}

/* `_used`: less of `taken` where next to nothing is left of the task's motion. */
static void use(Clear *c) {
    int64_t count = c->near + 2 * c->n, n = c->n, m = c->m;
    double whole = 0.0, left = 0.0;
    for (int64_t i = 0; i < count; i++) if (c->least[i] > 2.0 * c->tolerance) return;
    for (int64_t i = 0; i < m; i++) {
        double a = dot(c->J + i * n, c->asked, n);
        whole += a * a, left += a * dot(c->J + i * n, c->taken, n);
    }
    if (!(whole > 0.0)) return;
    double part = fmin(fmax((left / whole - c->nothing) / (c->something - c->nothing), 0.0), 1.0);
    for (int64_t j = 0; j < n; j++) c->taken[j] *= part;
}

static int finish(Clear *c) {
    int64_t n = c->n, m = c->m;
    double lost = 0.0, whole = 0.0;
    if (c->looked) use(c); /* it was corrected */
    for (int64_t i = 0; i < (m ? m : n); i++) {
        double a = m ? dot(c->J + i * n, c->asked, n) : c->asked[i];
        double b = a - (m ? dot(c->J + i * n, c->taken, n) : c->taken[i]);
        whole += a * a, lost += b * b;
    }
    c->row = -1;
    for (int64_t i = 0; i < c->near; i++)
        if (c->pushes[i] > 0.0 && (c->row < 0 || c->pushes[i] > c->pushes[c->row])) c->row = i;
    c->blocked = c->row >= 0 && lost > c->blocking * c->blocking * whole;
    if (c->row >= 0) c->row = c->felt[c->row];
    return CLEARED;
}

static int safe_anyway(const Clear *c) {
    double farthest = 0.0;
    for (int64_t j = 0; j < c->n; j++) farthest += fabs(c->taken[j]) * c->reach[j];
    return c->distance - farthest >= fmin(c->safe - c->loss, c->distance);
}

/* The step, shortened to the speed of its joints and to the zone. */
static void shorten(Clear *c) {
    int64_t n = c->n;
    double excess = 1.0, farthest = 0.0;
    for (int64_t j = 0; j < n && c->bounded == 1; j++) {
        double most = fmax(fabs(c->low[j]), fabs(c->high[j]));
        if (most > 0.0) excess = fmax(excess, fabs(c->step[j]) / most);
    }
    for (int64_t j = 0; j < n; j++) {
        c->taken[j] = excess > 1.0 ? c->step[j] / excess : c->step[j];
        farthest += fabs(c->taken[j]) * c->reach[j];
    }
    for (int64_t j = 0; j < n && farthest > c->zone; j++) c->taken[j] *= c->zone / farthest;
}

/* One call of a cycle: TAKE with raw pairs, which counts those that the joints feel, in `near`, and
 * finds the `distance` of the nearest; BEGIN with a
 * step; GO_ON with the bounds that were wanted; LOOKED with
 * the raw pairs after `taken`, which are corrected if `correct`; FINISH with what became of it. */
int fikm_clear(Clear *c, int stage) {
    int64_t n = c->n, near = c->near;
    if (stage == FINISH) return finish(c);
    if (stage == TAKE) {
        c->near = take(c, 0);
        c->distance = nearest(c->distances, c->near);
        return c->near < 0 ? TO_NUMPY : CLEARED;
    }
    if (stage == BEGIN) {
        int quiet = !c->moves;
        shorten(c);
        c->row = -1, c->blocked = 0, c->looked = 0;
        memcpy(c->asked, c->taken, sizeof c->asked);
        for (int64_t i = 0; i < near; i++) {
            double gap = c->distances[i] - c->safe, change = dot(c->rows + i * n, c->taken, n);
            double moved = c->moves ? c->moved[c->felt[i]] : 0.0;
            quiet &= gap >= 0.0 && change >= -c->least_share * gap;
            c->least[i] = change + moved;
        }
        for (int64_t j = 0; j < n && c->bounded == 1; j++)
            quiet &= c->taken[j] >= c->low[j] && c->taken[j] <= c->high[j];
        if (quiet) return CLEARED;
        for (int64_t i = 0; i < near; i++) {
            double moved = c->moves ? c->moved[c->felt[i]] : 0.0;
            c->least[i] = least_change(c, c->distances[i] - c->safe, c->least[i]) - moved;
        }
        if (c->bounded == 2) return WANT_BOUNDS;
    }
    if (stage == BEGIN || stage == GO_ON) {
        for (int64_t j = 0; j < n; j++) {
            c->least[near + j] = c->bounded && isfinite(c->low[j]) ? c->low[j] : -INFINITY;
            c->least[near + n + j] = c->bounded && isfinite(c->high[j]) ? -c->high[j] : -INFINITY;
        }
        if (metric(c)) return TO_NUMPY;
        ways_of(c, 0, near);
        if (project_rows(c, c->tolerance)) return TO_NUMPY;
        double factor = 1.0;
        for (int64_t i = 0; i < near + 2 * n; i++) {
            double change = along(c, i, c->taken);
            if (c->least[i] <= 0.0 && change < c->least[i] - 2.0 * c->tolerance)
                factor = fmin(factor, c->least[i] / change);
        }
        for (int64_t j = 0; j < n; j++) c->taken[j] *= factor;
        use(c);
        return safe_anyway(c) ? finish(c) : WANT_LOOK;
    }
    double floor_ = fmin(c->safe - c->loss, c->distance), pushes[NEAR_PAIRS];
    int64_t more = take(c, near);
    if (more < 0) return TO_NUMPY;
    if (nearest(c->distances + near, more) >= floor_) return finish(c);
    if (!c->correct) return WANT_LOOK;
    c->looked = more;
    ways_of(c, near, near + more);
    for (int64_t i = 0; i < more; i++)
        c->least[near + 2 * n + i] = floor_ + 0.5 * c->loss - c->distances[near + i] +
                                     dot(c->rows + (near + i) * n, c->taken, n);
    memcpy(pushes, c->pushes, sizeof pushes);
    if (project_rows(c, 0.0)) return TO_NUMPY;
    memcpy(c->pushes, pushes, sizeof pushes);
    return WANT_LOOK;
}
