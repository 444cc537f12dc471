/* Kinematics of a serial chain, its task errors and its scaled step, W postures side by side.
 *
 * The same arithmetic as the numpy code (kinematics/frames.py, solvers/batch/), which tells the
 * mathematics. A `vec` holds one number of W postures ("lanes"); lanes never mix, so results do not depend
 * on W. C99 with the vector types of GCC and Clang.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifndef ISA
#define ISA base
#define W 4
#endif
#define PASTE_(a, b) a##_##b
#define PASTE(a, b) PASTE_(a, b)
#define MAX_JOINTS 64
#define MAX_TARGET 12 /* coordinates of a target */
#define INLINE inline __attribute__((always_inline))
#define LANES(l) for (int l = 0; l < W; l++)

typedef double vec __attribute__((vector_size(8 * W)));
typedef int64_t mask __attribute__((vector_size(8 * W)));

/* A chain is one array of doubles: 12 numbers of the frame before the first joint turns (three axes, a
 * point), 7 a joint (what lies before it: x, a turn about x, y and z; the angle at zero), 12 of the tool,
 * then 3 a joint: lower limit, upper limit, unit (SCALE of a slide, 1 of a turn). */
enum { X, Y, Z, COS, SIN, OFFSET, REVOLUTE, JOINT };

static INLINE vec fill(double a) { return a - (vec){0.0}; }
static INLINE vec pick(mask m, vec a, vec b) { return (vec)(((mask)a & m) | ((mask)b & ~m)); }
static INLINE vec greater(vec a, vec b) { return pick(a > b, a, b); }
static INLINE vec less(vec a, vec b) { return pick(a < b, a, b); }
static INLINE vec size_of(vec a) { return (vec)((mask)a & INT64_MAX); }
static INLINE vec root(vec a) { vec r; LANES(l) r[l] = sqrt(a[l]); return r; }
static INLINE int any(mask m) { int64_t r = 0; LANES(l) r |= m[l]; return r != 0; }

/* Sines and cosines: Cody and Waite's reduction, fdlibm's polynomials; libm far from zero. */
static INLINE void sine_cosine(vec a, vec *sine, vec *cosine) {
    const double shift = 0x1.8p52;
    vec t = a * 0.63661977236758134308 + shift, k = t - shift;
    mask quadrant = (mask)t;
    vec r = a - k * 1.57079632673412561417e+00;
    r = r - k * 6.07710050630396597660e-11;
    r = r - k * 2.02226624879595063154e-21;
    vec z = r * r;
    vec s = r + r * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 +
        z * (-1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 +
        z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    vec c = 1.0 - (0.5 * z - z * z * (4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 +
        z * (2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 +
        z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
    mask odd = -(quadrant & 1);
    *sine = (vec)((mask)pick(odd, c, s) ^ ((quadrant & 2) << 62));
    *cosine = (vec)((mask)pick(odd, s, c) ^ (((quadrant + 1) & 2) << 62));
    if (any(size_of(a) > 1e6)) LANES(l) if (fabs(a[l]) > 1e6) {
        (*sine)[l] = sin(a[l]);
        (*cosine)[l] = cos(a[l]);
    }
}

/* atan2(s, c) of s >= 0, in [0, pi], by Cephes's rational function. */
static INLINE vec angle_of(vec s, vec c) {
    vec d = size_of(c), a = less(s, d), b = greater(greater(s, d), fill(1e-300));
    mask large = a > 0.41421356237309504880 * b;
    vec t = pick(large, a - b, a) / pick(large, a + b, b), z = t * t;
    vec p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
        7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1;
    vec q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
        4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2;
    vec y = t * z * (p / q) + t + pick(large, fill(0.78539816339744830962), fill(0.0));
    y = pick(s > d, 1.57079632679489661923 - y, y);
    return pick(c < 0.0, 3.14159265358979323846 - y, y);
}

typedef struct {
    vec axis[MAX_JOINTS][3], point[MAX_JOINTS][3]; /* of the joints */
    vec R[3][3], p[3];                             /* axes and point of the tool */
} Frames;

static INLINE void frames_of(const double *chain, int n, const vec *q, Frames *f) {
    vec x[3], y[3], z[3], p[3];
    for (int k = 0; k < 3; k++) {
        x[k] = fill(chain[k]), y[k] = fill(chain[3 + k]), z[k] = fill(chain[6 + k]);
        p[k] = fill(chain[9 + k]);
    }
    for (int i = 0; i < n; i++) {
        const double *e = chain + 12 + JOINT * i;
        for (int k = 0; k < 3; k++) {
            if (e[X] != 0.0) p[k] += e[X] * x[k];
            vec turned = e[COS] * y[k] + e[SIN] * z[k];
            z[k] = e[COS] * z[k] - e[SIN] * y[k];
            y[k] = turned;
            if (e[Y] != 0.0) p[k] += e[Y] * y[k];
            if (e[Z] != 0.0) p[k] += e[Z] * z[k];
            if (e[REVOLUTE] == 0.0) p[k] += q[i] * z[k];
            f->axis[i][k] = z[k], f->point[i][k] = p[k];
        }
        vec s, c;
        sine_cosine(e[REVOLUTE] == 0.0 ? fill(e[OFFSET]) : q[i] + e[OFFSET], &s, &c);
        for (int k = 0; k < 3; k++) {
            vec turned = c * x[k] + s * y[k];
            y[k] = c * y[k] - s * x[k];
            x[k] = turned;
        }
    }
    const double *tool = chain + 12 + JOINT * n;
    for (int k = 0; k < 3; k++) {
        f->p[k] = p[k] + tool[9] * x[k] + tool[10] * y[k] + tool[11] * z[k];
        for (int i = 0; i < 3; i++)
            f->R[i][k] = tool[3 * i] * x[k] + tool[3 * i + 1] * y[k] + tool[3 * i + 2] * z[k];
    }
}

/* Columns of the Jacobian, rows omega (times length) and v; length 0: rows v only. */
static INLINE void jacobian_of(const double *chain, int n, const Frames *f, double length,
                               vec J[MAX_JOINTS][6]) {
    int top = length > 0.0 ? 3 : 0;
    for (int j = 0; j < n; j++) {
        const vec *z = f->axis[j];
        int turns = chain[12 + JOINT * j + REVOLUTE] != 0.0;
        vec lever[3];
        for (int k = 0; k < 3; k++) lever[k] = f->p[k] - f->point[j][k];
        for (int k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            if (top) J[j][k] = turns ? length * z[k] : fill(0.0);
            J[j][top + k] = turns ? z[a] * lever[b] - z[b] * lever[a] : z[k];
        }
    }
}

/* dq = C J' y with (J C J' + damping R) y = e: the scaled step, `batch_step`. m is a constant. */
static INLINE void step_of(const int m, int n, vec J[MAX_JOINTS][6], vec *e, vec damping,
                           const vec *weight, double floor_, vec *dq) {
    vec C[MAX_JOINTS], R[6], M[6][6], most = fill(0.0), tiny = fill(0x1p-1022);
    for (int i = 0; i < m; i++) {
        R[i] = fill(0.0);
        for (int k = 0; k <= i; k++) M[i][k] = fill(0.0);
    }
    for (int j = 0; j < n; j++) {
        vec sum = fill(0.0);
        for (int i = 0; i < m; i++) sum += size_of(J[j][i]), R[i] += size_of(J[j][i]);
        most = greater(most, sum), C[j] = sum;
    }
    vec least = floor_ * floor_ * most * most + tiny;
    for (int j = 0; j < n; j++) {
        vec c = 1.0 / root(C[j] * C[j] + least);
        if (weight) c *= weight[j];
        C[j] = c;
        for (int i = 0; i < m; i++) {
            vec JC = J[j][i] * c;
            for (int k = 0; k <= i; k++) M[i][k] += JC * J[j][k];
        }
    }
    most = fill(0.0);
    for (int i = 0; i < m; i++) most = greater(most, R[i]);
    least = floor_ * floor_ * most * most + tiny;
    for (int i = 0; i < m; i++) M[i][i] += damping * root(R[i] * R[i] + least);
    for (int k = 0; k < m; k++) { /* L D L', the inverse of D in its place */
        M[k][k] = 1.0 / M[k][k];
        for (int i = k + 1; i < m; i++) {
            vec scaled = M[i][k] * M[k][k];
            e[i] -= scaled * e[k];
            for (int j = k + 1; j <= i; j++) M[i][j] -= scaled * M[j][k];
        }
        for (int i = k + 1; i < m; i++) M[i][k] *= M[k][k];
    }
    for (int k = m - 1; k >= 0; k--) {
        e[k] *= M[k][k];
        for (int i = k + 1; i < m; i++) e[k] -= M[i][k] * e[i];
    }
    for (int j = 0; j < n; j++) {
        vec sum = J[j][0] * e[0];
        for (int i = 1; i < m; i++) sum += J[j][i] * e[i];
        dq[j] = C[j] * sum;
    }
}

/* Rows (turn times length, offset) [m], distances [m] and angles [rad] from tools to targets, which are
 * three axes, then a point. */
static INLINE void error_of(const Frames *f, const vec *target, const int pose, double length, vec *e,
                            vec *distance, vec *angle) {
    vec square = fill(0.0), offset[3];
    for (int k = 0; k < 3; k++) {
        offset[k] = target[9 + k] - f->p[k];
        square += offset[k] * offset[k];
    }
    *distance = root(square);
    *angle = fill(0.0);
    if (pose) {
        vec turn[3], cosine = fill(-1.0);
        square = fill(0.0);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            turn[i] = fill(0.0);
            for (int a = 0; a < 3; a++) {
                turn[i] += 0.5 * (f->R[a][j] * target[3 * a + k] - f->R[a][k] * target[3 * a + j]);
                cosine += f->R[a][i] * target[3 * a + i];
            }
            square += turn[i] * turn[i];
        }
        cosine *= 0.5;
        vec sine = root(square);
        *angle = angle_of(sine, cosine);
        vec scale = pick(sine > 1e-9, *angle / greater(sine, fill(1e-9)), fill(1.0));
        for (int i = 0; i < 3; i++) e[i] = scale * turn[i];
        if (any(cosine < -0.99)) LANES(l) if (cosine[l] < -0.99) {
            /* Near half a turn the axis is that of E + E' = 2 cos I + 2 (1 - cos) a a'. */
            double E[3][3], norm = 0.0, sign = 0.0;
            int c = 0;
            for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) {
                E[i][j] = i == j ? -cosine[l] : 0.0;
                for (int a = 0; a < 3; a++)
                    E[i][j] += 0.5 * (target[3 * a + i][l] * f->R[a][j][l] +
                                      target[3 * a + j][l] * f->R[a][i][l]);
            }
            for (int i = 1; i < 3; i++) if (E[i][i] > E[c][c]) c = i;
            for (int i = 0; i < 3; i++) norm += E[i][c] * E[i][c], sign += E[i][c] * turn[i][l];
            norm = (sign < 0.0 ? -1.0 : 1.0) * (*angle)[l] / sqrt(norm);
            for (int i = 0; i < 3; i++) e[i][l] = norm * E[i][c];
        }
        for (int i = 0; i < 3; i++) e[i] *= length;
    }
    for (int k = 0; k < 3; k++) e[(pose ? 3 : 0) + k] = offset[k];
}
