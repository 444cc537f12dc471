/* What is compiled once, for no special instruction set: a law's step, and what the loader asks. */

const char fikm_source[] = SOURCE;

#define MOST_ERROR_DAMPING 1.0

static void divisors(double *sums, int count, double floor_, double zero) {
    double most = 0.0;
    for (int i = 0; i < count; i++) most = fmax(most, sums[i]);
    for (int i = 0; i < count; i++) {
        if (floor_ > 0.0 && most > 0.0) sums[i] = sqrt(sums[i] * sums[i] + floor_ * most * (floor_ * most));
        else if (sums[i] <= zero * most) sums[i] = INFINITY;
    }
}

/* `FuzzyMapping.step` of one J (m,n), m <= 6: the paper's law, or with growth > 0 the direct solve of
 * `normal_equations_of_one`; `extra` damping is a floor of the rows in the former. 1: the equations are
 * nearly singular, iterations do better. */
int fikm_step(int m, int n, const double *J, const double *dr, double row_floor, double column_floor,
              double zero, double damping, double error_damping, double extra, double growth, double *dq) {
    double R[6] = {0.0}, C[MAX_JOINTS] = {0.0}, M[6][6], y[6], before = 0.0, after = 0.0, turn = 0.0;
    if (growth > 0.0) damping = hypot(damping, extra);
    else row_floor = hypot(row_floor, extra);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) R[i] += fabs(J[i * n + j]), C[j] += fabs(J[i * n + j]);
    divisors(R, m, row_floor, zero);
    divisors(C, n, column_floor, zero);
    for (int i = 0; i < m; i++) y[i] = growth > 0.0 ? dr[i] : dr[i] / R[i];
    if (growth > 0.0) {
        for (int i = 0; i < m; i++) turn += dr[i] / R[i] * (dr[i] / R[i]);
        if (error_damping > 0.0)
            damping = hypot(damping, fmin(error_damping * sqrt(turn), MOST_ERROR_DAMPING));
        for (int i = 0; i < m; i++) {
            for (int k = 0; k <= i; k++) {
                M[i][k] = 0.0;
                for (int j = 0; j < n; j++) M[i][k] += J[i * n + j] / C[j] * J[k * n + j];
            }
            if (damping > 0.0) M[i][i] += damping * damping * R[i];
        }
        for (int k = 0; k < m; k++) {
            if (!(M[k][k] > 0.0)) return 1;
            for (int i = k + 1; i < m; i++) {
                double scaled = M[i][k] / M[k][k];
                y[i] -= scaled * y[k];
                for (int j = k + 1; j <= i; j++) M[i][j] -= scaled * M[j][k];
            }
        }
        for (int k = m - 1; k >= 0; k--) {
            y[k] /= M[k][k];
            for (int i = k + 1; i < m; i++) y[k] -= M[i][k] / M[k][k] * y[i];
        }
        for (int i = 0; i < m; i++) after += y[i] * y[i] * R[i], before += dr[i] * dr[i] / R[i];
        if (damping * damping * growth < 1.0 && !(after <= growth * growth * before)) return 1;
    }
    for (int j = 0; j < n; j++) {
        dq[j] = 0.0;
        for (int i = 0; i < m; i++) dq[j] += y[i] * J[i * n + j];
        dq[j] /= C[j];
    }
    return 0;
}

/* The best instruction set of this processor: 0 base, 1 avx2, 2 avx512. */
int fikm_processor(void) {
#if defined(__x86_64__) || defined(__i386__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) return 2;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return 1;
#endif
    return 0;
}
