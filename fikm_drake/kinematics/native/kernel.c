/* Inverse kinematics of many targets: the search of solvers/batch/, in C; lanes.h has the mathematics.
 *
 * Compiled once for each instruction set. Lengths are divided by SCALE, the chain's reach.
 */
#include "lanes.h"

enum { POSE, TOLERANCE, TURN_TOLERANCE, LENGTH, STEP, DAMPING, ERROR_DAMPING, FLOOR, BLOCKED,
       AT_LIMIT, LEAST_EXTRA, MOST_EXTRA, RAISE, LOWER, MAX_CYCLES, RESTARTS, WINDOW, PROGRESS,
       CAREFUL_WINDOW, CAREFUL_PROGRESS, SCALE, ORTHONORMAL, FARTHEST, REACH, NEAREST = REACH + 4,
       PLANAR, PLANE, SEEN = PLANE + 4, TOOL_POINT = SEEN + 3, SLACK = TOOL_POINT + 3 };
enum { INVALID, SOLVED, OUT_OF_REACH, NOT_SOLVED };

/* Poses (count,16) and Jacobians (count,6,n) of postures (count,n); either may be NULL. */
void PASTE(fikm_kinematics, ISA)(const double *chain, int n, int64_t count, const double *q,
                                 double *poses, double *J) {
    vec lanes[MAX_JOINTS], columns[MAX_JOINTS][6];
    Frames f;
    for (int64_t first = 0; first < count; first += W) {
        for (int j = 0; j < n; j++)
            LANES(l) lanes[j][l] = q[(first + l < count ? first + l : count - 1) * n + j];
        frames_of(chain, n, lanes, &f);
        if (J) jacobian_of(chain, n, &f, 1.0, columns);
        for (int l = 0; l < W && first + l < count; l++) {
            double *x = poses ? poses + 16 * (first + l) : NULL, *rows = J ? J + 6 * n * (first + l) : NULL;
            for (int k = 0; poses && k < 3; k++) {
                for (int i = 0; i < 3; i++) x[4 * k + i] = f.R[i][k][l];
                x[4 * k + 3] = f.p[k][l], x[12 + k] = 0.0;
            }
            if (poses) x[15] = 1.0;
            for (int k = 0; J && k < 6; k++)
                for (int j = 0; j < n; j++) rows[k * n + j] = columns[j][k][l];
        }
    }
}

enum { AHEAD = 4 }; /* targets that look for their nearest postures together */

/* One target being searched for. Attempt 0 is its first start, then come the nearest postures of the
 * pool; the first of them that arrives wins. The last attempt, careful, goes on from the best. */
typedef struct {
    int64_t target;
    int open, far, next, running, winner, nearest, best_attempt;
    double nearest_distance, size, distance, angle, goal[12], q[MAX_JOINTS];
} Search;

typedef struct {
    const double *chain, *o, *pool, *features, *targets, *starts;
    int n, pool_size, active, ahead_index[AHEAD];
    int64_t count, taken, stride, ahead;
    double ahead_distance[AHEAD], ahead_goals[AHEAD][12];
    double *q_out, *info, lower[MAX_JOINTS], upper[MAX_JOINTS], unit[MAX_JOINTS];
    int lane_search[W], attempt[W], cycle[W], *spent;
    Search searches[W];
    vec q[MAX_JOINTS], best_q[MAX_JOINTS], goal[12], size, distance, angle, checked, extra;
} Work;

/* For each of T goals the first of the pool's nearest tools that is farther than the one before. */
static INLINE void next_nearest(const Work *w, const int T, double (*goals)[12], double *distance,
                                int *index) {
    const double *F = w->features, scale = w->o[LENGTH] * 0.70710678118654752440;
    const int P = w->pool_size, rows = w->o[POSE] != 0.0 ? 12 : 3;
    double g[4][12];
    vec least[4], found[4], step;
    LANES(l) step[l] = l;
    for (int t = 0; t < T; t++) {
        least[t] = fill(INFINITY), found[t] = fill(0.0);
        for (int k = 0; k < rows; k++)
            g[t][k] = -2.0 * (k < 3 ? goals[t][9 + k] : scale * goals[t][k - 3]);
    }
    for (int i = 0; i < P; i += W) {
        vec d[4], x, here = step + (double)i;
        memcpy(&x, F + (rows == 12 ? 13 : 12) * P + i, sizeof x);
        for (int t = 0; t < T; t++) d[t] = x;
        for (int k = 0; k < rows; k++) {
            memcpy(&x, F + k * P + i, sizeof x);
            for (int t = 0; t < T; t++) d[t] += g[t][k] * x;
        }
        for (int t = 0; t < T; t++) {
            mask later = (d[t] > distance[t]) | ((d[t] == distance[t]) & (here > (double)index[t]));
            mask closer = later & (d[t] < least[t]);
            least[t] = pick(closer, d[t], least[t]), found[t] = pick(closer, here, found[t]);
        }
    }
    for (int t = 0; t < T; t++) {
        distance[t] = INFINITY, index[t] = 0;
        LANES(l) if (least[t][l] < distance[t] || (least[t][l] == distance[t] && found[t][l] < index[t]))
            distance[t] = least[t][l], index[t] = (int)found[t][l];
    }
}

/* Let a lane begin an attempt; 0 if there is none left that may begin now. */
static int begin(Work *w, int lane, Search *s) {
    int careful = (int)w->o[RESTARTS] + 1, attempt = s->next, n = w->n;
    if (!s->open || s->winner >= 0 || attempt > careful || (attempt == careful && s->running)) return 0;
    if (attempt == careful || attempt == 0) {
        for (int j = 0; j < n; j++) w->q[j][lane] = s->q[j];
    } else {
        if (attempt > 0) next_nearest(w, 1, &s->goal, &s->nearest_distance, &s->nearest);
        for (int j = 0; j < n; j++) w->q[j][lane] = w->pool[s->nearest * n + j];
    }
    s->next++, s->running++;
    w->lane_search[lane] = (int)(s - w->searches), w->attempt[lane] = attempt, w->cycle[lane] = 0;
    w->size[lane] = w->checked[lane] = INFINITY, w->extra[lane] = 0.0;
    for (int k = 0; k < 12; k++) w->goal[k][lane] = s->goal[k];
    return 1;
}

static int valid(const double *o, const double *x) {
    int pose = o[POSE] != 0.0;
    for (int i = 0; i < (pose ? 16 : 3); i++) if (!(fabs(x[i]) < o[FARTHEST])) return 0;
    if (!pose) return 1;
    for (int i = 0; i < 4; i++) if (!(fabs(x[12 + i] - (i == 3)) <= o[ORTHONORMAL])) return 0;
    for (int i = 0; i < 3; i++) for (int j = 0; j <= i; j++) {
        double d = x[4 * i] * x[4 * j] + x[4 * i + 1] * x[4 * j + 1] + x[4 * i + 2] * x[4 * j + 2];
        if (!(fabs(d - (i == j)) <= o[ORTHONORMAL])) return 0;
    }
    return x[0] * (x[5] * x[10] - x[6] * x[9]) - x[1] * (x[4] * x[10] - x[6] * x[8]) +
           x[2] * (x[4] * x[9] - x[5] * x[8]) > 0.0;
}

/* Whether the target is proven to be out of reach: `Reach`. */
static int too_far(const double *o, const double *goal) {
    double p[3], square = 0.0, off = -o[PLANE + 3], tilt[3] = {0}, dot = 0.0, cross = 0.0;
    for (int k = 0; k < 3; k++) {
        p[k] = goal[9 + k];
        off += goal[9 + k] * o[PLANE + k];
        if (o[POSE] != 0.0) for (int i = 0; i < 3; i++) {
            p[k] += goal[3 * i + k] * o[TOOL_POINT + i];
            tilt[k] += goal[3 * i + k] * o[SEEN + i];
        }
        square += (p[k] - o[REACH + k]) * (p[k] - o[REACH + k]);
    }
    double d = sqrt(square);
    if (d > o[REACH + 3] || d < o[NEAREST]) return 1;
    if (o[PLANAR] == 0.0) return 0;
    if (fabs(off) > o[SLACK]) return 1;
    if (o[POSE] == 0.0) return 0;
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        double c = tilt[a] * o[PLANE + b] - tilt[b] * o[PLANE + a];
        dot += tilt[k] * o[PLANE + k], cross += c * c;
    }
    return atan2(sqrt(cross), dot) > o[SLACK + 1];
}

static void write_out(Work *w, Search *s, int attempts) {
    double *q = w->q_out + s->target * w->n, *info = w->info + 4 * s->target, cycles = 0.0;
    int *spent = w->spent + (s - w->searches) * ((int)w->o[RESTARTS] + 2);
    for (int a = 0; a < attempts; a++) cycles += spent[a];
    for (int j = 0; j < w->n; j++) q[j] = s->q[j] * w->unit[j];
    info[0] = s->winner >= 0 ? SOLVED : s->far ? OUT_OF_REACH : NOT_SOLVED;
    info[1] = cycles, info[2] = s->distance * w->o[SCALE], info[3] = s->angle;
    s->open = 0;
}

static void goal_of(const Work *w, int64_t t, double *goal) {
    const int pose = w->o[POSE] != 0.0;
    const double *x = w->targets + t * (pose ? 16 : 3), scale = 1.0 / w->o[SCALE];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; pose && i < 3; i++) goal[3 * i + k] = x[4 * k + i];
        goal[9 + k] = scale * (pose ? x[4 * k + 3] : x[k]);
    }
}

/* Take up the next target; 0 if there is none. Invalid ones are answered at once. */
static int open_search(Work *w, int lane) {
    int slot = 0, n = w->n, attempts = (int)w->o[RESTARTS] + 2;
    while (w->searches[slot].open) slot++;
    Search *s = &w->searches[slot];
    while (w->taken < w->count) {
        int64_t t = w->taken++;
        double *info = w->info + 4 * t;
        if (!w->starts && t >= w->ahead) {
            for (int i = 0; i < AHEAD; i++) {
                goal_of(w, t + i < w->count ? t + i : t, w->ahead_goals[i]);
                w->ahead_distance[i] = -INFINITY;
            }
            next_nearest(w, AHEAD, w->ahead_goals, w->ahead_distance, w->ahead_index);
            w->ahead = t + AHEAD;
        }
        if (!valid(w->o, w->targets + t * (w->o[POSE] != 0.0 ? 16 : 3))) {
            info[0] = INVALID, info[1] = 0.0, info[2] = info[3] = NAN;
            continue;
        }
        goal_of(w, t, s->goal);
        s->target = t, s->open = 1, s->running = 0, s->winner = s->best_attempt = s->nearest = -1;
        s->nearest_distance = -INFINITY, s->size = INFINITY, s->far = too_far(w->o, s->goal);
        s->next = s->far ? attempts - 1 : 0;
        memset(w->spent + slot * attempts, 0, sizeof(int) * (size_t)attempts);
        if (!w->starts) {
            int i = (int)(t - w->ahead + AHEAD);
            s->nearest = w->ahead_index[i], s->nearest_distance = w->ahead_distance[i];
        }
        const double *start = w->starts ? w->starts + t * w->stride : w->pool + s->nearest * n;
        for (int j = 0; j < n; j++) s->q[j] = w->starts ? start[j] / w->unit[j] : start[j];
        return begin(w, lane, s);
    }
    return 0;
}

/* Keep a lane's end; decide its target where it can be; find the lane other work. */
static void end_attempt(Work *w, int lane, int solved) {
    Search *s = &w->searches[w->lane_search[lane]];
    int attempt = w->attempt[lane], careful = (int)w->o[RESTARTS] + 1, decided = 1;
    w->spent[(s - w->searches) * (careful + 1) + attempt] = w->cycle[lane];
    w->attempt[lane] = -1, s->running--, w->active--;
    double size = w->size[lane];
    if (solved ? s->winner < 0 || attempt < s->winner
               : s->winner < 0 && (size < s->size || (size == s->size && attempt < s->best_attempt))) {
        if (solved) s->winner = attempt;
        s->size = size, s->best_attempt = attempt;
        s->distance = w->distance[lane], s->angle = w->angle[lane];
        for (int j = 0; j < w->n; j++) s->q[j] = w->best_q[j][lane];
    }
    LANES(l) if (w->attempt[l] >= 0 && &w->searches[w->lane_search[l]] == s) {
        if (s->winner < 0 || w->attempt[l] < s->winner) decided = 0;
        else w->attempt[l] = -1, s->running--, w->active--;
    }
    if (decided && (s->winner >= 0 || attempt == careful))
        write_out(w, s, (s->winner >= 0 ? s->winner : careful) + 1);
}

static void find_work(Work *w, int lane) {
    int found = begin(w, lane, &w->searches[w->lane_search[lane]]) || open_search(w, lane);
    for (int i = 0; i < W && !found; i++) found = begin(w, lane, &w->searches[i]);
    w->active += found;
}

/* One cycle of all lanes after the other until every target has its answer. */
static INLINE void search(Work *w, const int pose) {
    const double *chain = w->chain, *o = w->o;
    const int n = w->n, m = pose ? 6 : 3, careful = (int)o[RESTARTS] + 1;
    while (w->active) {
        Frames f;
        vec J[MAX_JOINTS][6], e[6], dq[MAX_JOINTS], weight[MAX_JOINTS], distance, angle;
        frames_of(chain, n, w->q, &f);
        error_of(&f, w->goal, pose, o[LENGTH], e, &distance, &angle);
        vec square = fill(0.0);
        for (int i = 0; i < m; i++) square += e[i] * e[i];
        vec size = root(square);
        mask solved = (distance <= o[TOLERANCE]) & (angle <= o[TURN_TOLERANCE]);
        mask better = (size < w->size) | solved, worse = ~better & (size > w->size);
        w->size = pick(better, size, w->size);
        w->distance = pick(better, distance, w->distance), w->angle = pick(better, angle, w->angle);
        for (int j = 0; j < n; j++) w->best_q[j] = pick(better, w->q[j], w->best_q[j]);

        jacobian_of(chain, n, &f, pose ? o[LENGTH] : 0.0, J);
        vec near = less(size, fill(o[STEP])), factor = near / greater(size, fill(1e-300));
        for (int i = 0; i < m; i++) e[i] *= factor;
        vec damping = o[DAMPING] + o[ERROR_DAMPING] * near;
        mask being_careful, at_limit = {0};
        LANES(l) being_careful[l] = w->attempt[l] == careful ? -1 : 0;
        vec raised = less(greater(w->extra * o[RAISE], fill(o[LEAST_EXTRA])), fill(o[MOST_EXTRA]));
        w->extra = pick(being_careful, pick(worse, raised, w->extra * o[LOWER]), fill(0.0));
        for (int j = 0; j < n; j++)
            at_limit |= (w->q[j] <= w->lower[j] + o[AT_LIMIT]) | (w->q[j] >= w->upper[j] - o[AT_LIMIT]);
        int limited = any(at_limit);
        for (int j = 0; limited && j < n; j++) {
            vec push = fill(0.0);
            for (int i = 0; i < m; i++) push += J[j][i] * e[i];
            mask blocked = ((w->q[j] <= w->lower[j] + o[AT_LIMIT]) & (push < 0.0)) |
                           ((w->q[j] >= w->upper[j] - o[AT_LIMIT]) & (push > 0.0));
            weight[j] = pick(blocked, fill(o[BLOCKED]), fill(1.0));
        }
        step_of(m, n, J, e, damping + w->extra, limited ? weight : NULL, o[FLOOR], dq);
        mask back = being_careful & worse;
        for (int j = 0; j < n; j++) {
            vec q = less(greater(w->q[j] + dq[j], fill(w->lower[j])), fill(w->upper[j]));
            w->q[j] = pick(back, w->best_q[j], q);
        }
        LANES(l) {
            if (w->attempt[l] < 0) continue;
            int slow = w->attempt[l] == careful, k = w->cycle[l], window = (int)o[slow ? CAREFUL_WINDOW : WINDOW];
            int stop = k == (slow ? 2 : 1) * (int)o[MAX_CYCLES];
            if (!stop && k && k % window == 0) {
                stop = w->checked[l] - w->size[l] <
                       o[slow ? CAREFUL_PROGRESS : PROGRESS] * fmin(w->checked[l], o[STEP]);
                w->checked[l] = w->size[l];
            }
            if (solved[l] || stop) end_attempt(w, l, solved[l] != 0);
            else w->cycle[l]++;
        }
        LANES(l) if (w->attempt[l] < 0) find_work(w, l);
    }
}

/* Joint positions (count,n) for targets, (count,3) or (count,16), and info (count,4): status, cycles,
 * errors [m], [rad]. starts: one for all (stride 0), one a target (stride n), or NULL: the pool's nearest.
 * features: the pool's tool points (3), scaled axes (9), squares of three and of twelve rows. */
int PASTE(fikm_solve, ISA)(const double *chain, int n, const double *o, const double *pool,
                           const double *features, int pool_size, int64_t count,
                           const double *targets, const double *starts, int64_t stride,
                           double *q_out, double *info) {
    void *memory = calloc(1, sizeof(Work) + 64);
    int *spent = calloc((size_t)W * (size_t)(o[RESTARTS] + 2), sizeof(int));
    if (!memory || !spent) { free(memory); free(spent); return 1; }
    Work *w = (Work *)(((uintptr_t)memory + 63) & ~(uintptr_t)63);
    const double *limits = chain + 24 + JOINT * n;
    w->chain = chain, w->o = o, w->pool = pool, w->features = features, w->targets = targets;
    w->starts = starts, w->n = n, w->pool_size = pool_size, w->count = count, w->stride = stride;
    w->q_out = q_out, w->info = info, w->spent = spent;
    for (int j = 0; j < n; j++) {
        w->unit[j] = limits[3 * j + 2];
        w->lower[j] = limits[3 * j] / w->unit[j], w->upper[j] = limits[3 * j + 1] / w->unit[j];
    }
    LANES(l) w->attempt[l] = -1;
    LANES(l) find_work(w, l);
    if (o[POSE] != 0.0) search(w, 1);
    else search(w, 0);
    free(memory);
    free(spent);
    return 0;
}

#ifdef SOURCE
#include "base.h"
#include "curve.h"
#include "clearance.h"
#include "supervision.h"
#include "task.h"
#include "limits.h"
#include "saturation.h"
#include "retreat.h"
#include "safe_step.h"
#include "restart.h"
#include "cycle.h"
#endif
