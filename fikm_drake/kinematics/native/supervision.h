/* The gain supervisor of control/: gain_supervision.py, motion_windows.py and calm_rule.py, step by step.
 *
 * The memory is theirs, a vector of doubles: ten numbers, then errors (window), signs (n), a ring of who
 * turned round (window - 1, n), then the two windows of motion. Options come from Python, in this order.
 */
enum { S_ROWS, S_JOINTS, S_COORDINATES, S_WINDOW, S_SLOW_WINDOW, S_TURNS, S_SLOW_TURNS, S_DEAD_BAND,
       S_ERROR_LIMIT, S_TOLERANCE, S_BREAKPOINTS, S_GAINS = S_BREAKPOINTS + 3,
       S_AT_REST = S_GAINS + 6, S_DOMINANT, S_FADING, S_HUGE, S_CALMING, S_RECOVERY, S_CALM_DAMPING,
       S_DAMPED_FIRST, S_RANGE, S_LEAST_CALM, S_CANCELLED, S_CONSISTENT, S_EXPLAINED, S_NOISY, S_STAYS,
       S_AWAKE, S_PROGRESS, S_LEAST_PROGRESS, S_CHANGES, S_LASTS, S_NEAR, S_JUMP, S_CREEPS, S_STILL, S_DEEP,
       S_ROUNDED, S_COUNT };
enum { KNOWN, CALM, TURNS_OF_MOST, WATCHED, TURN, TURN_BEFORE, TURNS, TICKS, SHAKES, RESTS, ERRORS };

/* Where the windows of motion are in the memory. */
typedef struct {
    double *cycles, *largest, *last_size, *most, *last_error, *last_target, *last_deviation, *fast, *slow;
    int n, m, c, rows, size, block;
} Windows;

static Windows windows_of(double *memory, const double *o) {
    Windows w = {.n = (int)o[S_JOINTS], .m = (int)o[S_ROWS], .c = (int)o[S_COORDINATES]};
    w.rows = (int)o[S_WINDOW] - 1, w.size = 2 * w.n + w.m + w.c + 7;
    w.block = ((int)o[S_SLOW_WINDOW] - 1) / w.rows;
    if (w.block < 1) w.block = 1;
    w.cycles = memory + ERRORS + w.rows + 1 + w.n * (1 + w.rows);
    w.largest = w.cycles + 1, w.last_size = w.cycles + 2, w.most = w.cycles + 3;
    w.last_error = w.cycles + 4;
    w.last_target = w.last_error + w.m, w.last_deviation = w.last_target + w.c;
    w.fast = w.last_deviation + w.n, w.slow = w.fast + w.rows * w.size;
    return w;
}

static double square_of(const double *x, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += x[i] * x[i];
    return sum;
}

static void start_windows(Windows *w) {
    memset(w->fast, 0, sizeof(double) * 2 * (size_t)(w->rows * w->size));
    *w->cycles = *w->largest = *w->most = 0.0, *w->last_size = -1.0;
}

static double damping_of(const double *memory, const double *o) {
    double calm = memory[CALM];
    return calm == 1.0 ? 0.0 : o[S_CALM_DAMPING] * fmin(1.0, (1.0 - calm) / o[S_RANGE]);
}

/* Table I at an error of this length, times the calm. */
double fikm_gain(const double *memory, const double *o, double error) {
    const double *knots = o + S_BREAKPOINTS, *gains = o + S_GAINS;
    const int window = (int)o[S_WINDOW], known = (int)fmod(memory[KNOWN], window);
    double relative = knots[1], sum = 0.0, calm = memory[CALM];
    if (o[S_ERROR_LIMIT] < error && error < INFINITY) error = o[S_ERROR_LIMIT];
    if (!(0.0 < error && error < INFINITY)) relative = error == 0.0 ? 0.0 : INFINITY;
    else if (!(memory[KNOWN] + 1.0 < window)) {
        for (int i = 0; i < window; i++) sum += i == known ? error : memory[ERRORS + i];
        relative = error * window / sum;
    }
    int i = relative < knots[1] ? 0 : 1;
    double f = fmax(0.0, fmin(1.0, (relative - knots[i]) / (knots[i + 1] - knots[i])));
    double g = fmax(0.0, fmin(1.0, memory[TURNS_OF_MOST] - (o[S_TURNS] - 1.0)));
    const double *low = gains + 2 * i, *high = low + 2;
    double gain = (1.0 - f) * ((1.0 - g) * low[0] + g * low[1]) +
                  f * ((1.0 - g) * high[0] + g * high[1]);
    return calm == 1.0 ? gain : fmin(1.0, calm / o[S_DAMPED_FIRST]) * gain;
}

/* What was seen of a cycle: size, square, whether a joint turned, who (n), joint step (n). */
enum { SEEN_SIZE, SEEN_SQUARE, SEEN_TURN, SEEN_FLIPS };

/* `remember_turns`: 1 if the motion is watched; then `seen` is for `fikm_remember_motion`. */
int fikm_remember_turns(double *memory, const double *o, const double *error, const double *joint_step,
                        double *seen) {
    Windows w = windows_of(memory, o);
    const int n = w.n, window = w.rows + 1;
    const double known = memory[KNOWN], dead = o[S_DEAD_BAND];
    double *signs = memory + ERRORS + window, *ring = signs + n, *flips = seen + SEEN_FLIPS;
    double *step = flips + n, size = square_of(error, w.m);
    size = size < o[S_HUGE] * o[S_HUGE] ? sqrt(size) : INFINITY;
    if (0.0 < size && size < INFINITY) {
        memory[ERRORS + (int)fmod(known, window)] = fmin(size, o[S_ERROR_LIMIT]);
        memory[KNOWN] = known + 1.0;
    }
    memcpy(step, joint_step, sizeof(double) * (size_t)n);
    double square = square_of(step, n);
    if (!(square < o[S_HUGE] * o[S_HUGE])) {
        for (int j = 0; j < n; j++) if (!(fabs(step[j]) < o[S_HUGE])) step[j] = 0.0;
        square = square_of(step, n);
    }
    int turned = 0, forgotten = 0;
    for (int j = 0; j < n; j++) {
        flips[j] = 0.0;
        if (!(square > dead * dead && fabs(step[j]) > dead)) continue;
        double sign = step[j] > 0.0 ? 1.0 : -1.0;
        if (sign * signs[j] < 0.0) flips[j] = 1.0, turned = 1;
        signs[j] = sign;
    }
    if (!turned && memory[WATCHED] == 0.0 && memory[TURNS_OF_MOST] == 0.0) return 0;
    double *oldest = ring + n * (int)fmod(memory[TICKS], w.rows);
    for (int j = 0; j < n; j++) forgotten |= oldest[j] != 0.0;
    if (turned || forgotten) { /* else the counts stay */
        memory[TURNS_OF_MOST] = 0.0;
        memcpy(oldest, flips, sizeof(double) * (size_t)n);
        for (int j = 0; j < n; j++) {
            double count = 0.0;
            for (int i = 0; i < w.rows; i++) count += ring[i * n + j];
            memory[TURNS_OF_MOST] = fmax(memory[TURNS_OF_MOST], count);
        }
    }
    memory[TICKS] += 1.0;
    if (turned) {
        double late = memory[TURN_BEFORE];
        memory[TURNS] += 1.0;
        memory[TURN_BEFORE] = memory[TURN], memory[TURN] = known;
        if (memory[WATCHED] == 0.0 && known - late <= o[S_SLOW_WINDOW]) {
            memory[WATCHED] = memory[TURNS] = 1.0;
            start_windows(&w);
        }
    }
    if (memory[WATCHED] != 0.0 && memory[CALM] == 1.0 && known - memory[TURN] >= o[S_SLOW_WINDOW])
        memory[WATCHED] = 0.0, memory[SHAKES] = -1.0;
    seen[SEEN_SIZE] = size, seen[SEEN_SQUARE] = square, seen[SEEN_TURN] = turned;
    return memory[WATCHED] != 0.0 && !(memory[CALM] == 1.0 && size <= o[S_TOLERANCE]);
}

/* Write a cycle into the windows; how far the target moved. */
static double add_motion(Windows *w, const double *o, double size, const double *error,
                         const double *target, const double *seen, const double *deviation) {
    const int cycles = (int)*w->cycles, n = w->n;
    double last_size = *w->last_size, strayed = 0.0, moved = 0.0, shift = 0.0, most = 0.0;
    if (last_size < 0.0) { /* nothing to compare with */
        memcpy(w->last_error, error, sizeof(double) * (size_t)w->m);
        memcpy(w->last_target, target, sizeof(double) * (size_t)w->c);
        for (int j = 0; j < n; j++) w->last_deviation[j] = deviation ? deviation[j] : 0.0;
        last_size = size;
    }
    for (int j = 0; deviation && j < n; j++) {
        double change = deviation[j] - w->last_deviation[j];
        strayed += change * change, w->last_deviation[j] = deviation[j];
    }
    double *row = w->fast + w->size * (cycles % w->rows), *x = row;
    const double *step = seen + SEEN_FLIPS + n;
    for (int j = 0; j < n; j++) *x++ = step[j], most = fmax(most, fabs(step[j]));
    for (int i = 0; i < w->m; i++, x++) {
        *x = error[i] - w->last_error[i];
        moved += *x * *x, w->last_error[i] = error[i];
    }
    for (int i = 0; i < w->c; i++, x++) {
        *x = target[i] - w->last_target[i];
        shift += *x * *x, w->last_target[i] = target[i];
    }
    most = fmax(most, o[S_FADING] * *w->largest);
    for (int j = 0; j < n; j++) *x++ = fabs(step[j]) > o[S_DOMINANT] * most ? seen[SEEN_FLIPS + j] : 0.0;
    const double lengths[] = {sqrt(seen[SEEN_SQUARE]), sqrt(moved), sqrt(shift), fmax(size, 0.0),
                              last_size - size, fabs(last_size - size), sqrt(strayed)};
    memcpy(x, lengths, sizeof lengths);
    double *block = w->slow + w->size * (cycles / w->block % w->rows);
    if (cycles % w->block) for (int i = 0; i < w->size; i++) block[i] += row[i];
    else memcpy(block, row, sizeof(double) * (size_t)w->size);
    *w->cycles = cycles + 1, *w->largest = most, *w->last_size = size, *w->most = 0.0;
    for (int j = 0; j < n; j++) {
        double count = 0.0;
        for (int i = 0; i < w->rows; i++) count += w->slow[i * w->size + n + w->m + w->c + j];
        *w->most = fmax(*w->most, count);
    }
    return sqrt(shift);
}

/* `Motion`, the sums over a window; `cancelled` is its property. */
typedef struct {
    double net_step, path_step, path_error, net_error, net_target, path_target, changes, mean_error, fall,
        rough, path_deviation, cancelled;
    int joint, cycles;
} Motion;

static Motion motion_of(const Windows *w, const double *ring, int cycles) {
    double sums[2 * MAX_JOINTS + 2 * MAX_TARGET + 7] = {0.0};
    for (int i = 0; i < w->rows; i++)
        for (int k = 0; k < w->size; k++) sums[k] += ring[i * w->size + k];
    const double *error = sums + w->n, *target = error + w->m, *flips = target + w->c, *s = flips + w->n;
    Motion a = {.path_step = s[0], .path_error = s[1], .path_target = s[2], .fall = s[4], .rough = s[5],
                .path_deviation = s[6], .changes = flips[0], .cycles = cycles};
    a.net_step = sqrt(square_of(sums, w->n)), a.net_error = sqrt(square_of(error, w->m));
    a.net_target = sqrt(square_of(target, w->c));
    a.mean_error = cycles ? s[3] / cycles : INFINITY;
    a.cancelled = a.path_step > 0.0 ? 1.0 - a.net_step / a.path_step : 0.0;
    for (int j = 1; j < w->n; j++) if (flips[j] > a.changes) a.changes = flips[j], a.joint = j;
    return a;
}

static int noisy(const double *o, const Motion *a) { return a->path_deviation > o[S_NOISY] * a->path_step; }

static int to_and_fro(const double *o, const Motion *a) {
    if (a->cancelled <= o[S_CANCELLED] || noisy(o, a)) return 0;
    double explains = o[S_EXPLAINED] * (a->path_error - a->net_error);
    return !(a->path_target - a->net_target > explains + o[S_ROUNDED] * a->path_target);
}

static int shaking_joint(const double *o, double error, const Motion *fast, const Motion *slow) {
    if (noisy(o, slow)) return -1;
    if (fast->changes >= o[S_TURNS] && to_and_fro(o, fast)) return fast->joint;
    if (slow->changes >= o[S_SLOW_TURNS] && to_and_fro(o, slow))
        return error > o[S_STAYS] * slow->mean_error ? slow->joint : -1;
    return -1;
}

static double lowered(const double *o, double calm) { return fmax(o[S_LEAST_CALM], calm * o[S_CALMING]); }
static double raised(const double *o, double calm) { return fmin(1.0, calm * o[S_RECOVERY]); }
static double awake(const double *o, double calm) { return raised(o, fmax(o[S_AWAKE], calm)); }

static double undisturbed(const double *o, double calm, double error, const Motion *fast,
                          const Motion *slow, int rests) {
    if (calm == 1.0) return calm;
    double progress = o[S_PROGRESS] * fmax(calm, o[S_LEAST_PROGRESS]) * (o[S_WINDOW] - 1.0) * error;
    int falls = fast->fall - fast->net_target > fmax(progress, (1.0 - o[S_CONSISTENT]) * fast->rough);
    if (falls && slow->fall > o[S_LASTS] * slow->rough) return awake(o, calm);
    int runs = fast->path_step > 0.0 && fast->cancelled < o[S_CONSISTENT] &&
               slow->cancelled < o[S_CANCELLED];
    if (runs && fabs(fast->fall) > o[S_CHANGES] * error) {
        if (error < o[S_NEAR] * fast->net_target) return awake(o, calm);
        return fmax(calm, fmin(o[S_DAMPED_FIRST], awake(o, calm)));
    }
    if (rests && calm < o[S_DEEP] * o[S_DAMPED_FIRST]) return lowered(o, calm);
    int creeps = slow->fall < o[S_CREEPS] * calm * slow->cycles * error;
    if (creeps && slow->cycles > o[S_WINDOW] - 1.0 && slow->net_target < o[S_STILL] * error)
        return lowered(o, calm);
    return calm;
}

/* `remember_motion`; target (c), deviation (n) or NULL. `seen` is changed. */
void fikm_remember_motion(double *memory, const double *o, double *seen, const double *error,
                          const double *target, const double *deviation) {
    Windows w = windows_of(memory, o);
    double size = seen[SEEN_SIZE], huge = o[S_HUGE], kept_error[MAX_TARGET], kept_target[MAX_TARGET];
    if (!(0.0 < size && size < huge && square_of(target, w.c) < huge * huge)) {
        /* No error to go by: on from the last that was. */
        memcpy(kept_error, w.last_error, sizeof(double) * (size_t)w.m);
        memcpy(kept_target, w.last_target, sizeof(double) * (size_t)w.c);
        error = kept_error, target = kept_target, size = *w.last_size, deviation = NULL;
    }
    if (deviation && !(square_of(deviation, w.n) < huge * huge)) deviation = NULL;
    if (size <= o[S_TOLERANCE]) { /* to and fro there is nothing to calm */
        seen[SEEN_SQUARE] = 0.0;
        memset(seen + SEEN_FLIPS, 0, sizeof(double) * 2 * (size_t)w.n);
    }
    double shift = add_motion(&w, o, size, error, target, seen, deviation);
    double before = memory[CALM], calm = before, late = fmod(*w.cycles - 1.0, w.block) + 1.0;
    if (!(before < 1.0 || memory[TURNS] >= o[S_TURNS])) return;
    Motion fast = motion_of(&w, w.fast, (int)fmin(*w.cycles, w.rows));
    Motion slow = motion_of(&w, w.slow, (int)fmin(*w.cycles, (w.rows - 1) * w.block + late));
    if (size <= o[S_TOLERANCE]) calm = raised(o, calm);
    else if (shift > o[S_JUMP] * size && calm < 1.0) {
        calm = awake(o, calm);
        start_windows(&w); /* what was seen holds no more */
        memory[RESTS] = 0.0;
    } else {
        int joint = shaking_joint(o, size, &fast, &slow);
        if (joint >= 0) memory[SHAKES] = joint, calm = lowered(o, calm);
        else calm = undisturbed(o, calm, size, &fast, &slow, memory[RESTS] != 0.0);
    }
    if (*w.cycles >= w.rows) memory[RESTS] = fast.path_step < o[S_AT_REST] * w.rows;
    if (calm <= o[S_DAMPED_FIRST] && o[S_DAMPED_FIRST] < before) /* less gain only if they shake damped too */
        for (int i = 0; i < 2 * w.rows; i++)
            memset(w.fast + i * w.size + w.n + w.m + w.c, 0, sizeof(double) * (size_t)w.n), *w.most = 0.0;
    memory[CALM] = calm;
}
