/* A task of turns and offsets of a chain's tool: its error, its Jacobian, its target. */
enum { T_TURNS, T_LENGTH, T_ROWS, T_ROW, T_COUNT = T_ROW + 6 };
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

/* Numbers of a target by which `remember_motion` tells how far it moves. */
static void coordinates_of(const double *t, int count, const double *target, double *x) {
    if (t[T_TURNS] == 0.0) { memcpy(x, target, sizeof(double) * (size_t)count); return; }
    const int columns = count / 3;
    for (int k = 0; k < 3; k++) for (int i = 0; i < columns; i++)
        x[k * columns + i] = target[4 * k + i] * (i < 3 ? t[T_LENGTH] / 1.41421356237309504880 : 1.0);
}
