/* Vectors, rotations, poses, and matrices of any size. Angles are in radians. Results may be an argument.
 *
 * A function returns GO_RESULT_OK, or the reason why there is no result. Except in go_matrix_inv, the result is then
 * left alone. */
#ifndef GOMATH_H
#define GOMATH_H
#include "gotypes.h"

#define GO_PI PM_PI
#define GO_2_PI PM_2_PI
#define GO_PI_2 PM_PI_2
#define GO_PI_4 PM_PI_4
#define GO_TO_DEG(rad) ((rad) * TO_DEG)
#define GO_TO_RAD(deg) ((deg) * TO_RAD)
#define go_sin(x) sin(x)
#define go_cos(x) cos(x)
#define go_tan(x) tan(x)
#define go_sqrt(x) sqrt(x)
#define go_fabs(x) fabs(x)
#define go_atan2(y, x) atan2((y), (x))

static inline go_real go_sq(go_real x) { return x * x; }
static inline go_flag go_close(go_real a, go_real b) { return fabs(a - b) < 1e-10; }
static inline go_flag go_small(go_real x) { return fabs(x) < 1e-10; }

static inline go_cart go_cart_zero(void) { return (go_cart){0, 0, 0}; }
static inline go_result go_cart_cart_dot(const go_cart *a, const go_cart *b, go_real *d)
{
    return pmCartCartDot(a, b, d);
}
static inline go_result go_cart_cart_cross(const go_cart *a, const go_cart *b, go_cart *out)
{
    return pmCartCartCross(a, b, out);
}
static inline go_result go_cart_mag(const go_cart *v, go_real *d) { return pmCartMag(v, d); }
static inline go_result go_cart_magsq(const go_cart *v, go_real *d) { return pmCartMagSq(v, d); }
static inline go_result go_cart_cart_add(const go_cart *a, const go_cart *b, go_cart *out)
{
    return pmCartCartAdd(a, b, out);
}
static inline go_result go_cart_cart_sub(const go_cart *a, const go_cart *b, go_cart *out)
{
    return pmCartCartSub(a, b, out);
}
static inline go_result go_cart_cart_disp(const go_cart *a, const go_cart *b, go_real *d)
{
    return pmCartCartDisp(a, b, d);
}
static inline go_flag go_cart_cart_compare(const go_cart *a, const go_cart *b)
{
    return go_close(a->x, b->x) && go_close(a->y, b->y) && go_close(a->z, b->z);
}
static inline go_result go_cart_scale_mult(const go_cart *v, go_real k, go_cart *out)
{
    return pmCartScalMult(v, k, out);
}
static inline go_result go_cart_neg(const go_cart *v, go_cart *out)
{
    *out = (go_cart){-v->x, -v->y, -v->z};
    return GO_RESULT_OK;
}
static inline go_result go_cart_unit(const go_cart *v, go_cart *out)
{
    go_real d;
    pmCartMag(v, &d);
    if (d == 0.0)
        return GO_RESULT_NORM_ERROR;
    return pmCartScalMult(v, 1.0 / d, out);
}

static inline go_quat go_quat_this(void) { return (go_quat){1, 0, 0, 0}; }
static inline go_result go_quat_inv(const go_quat *q, go_quat *out) { return pmQuatInv(q, out); }
static inline go_result go_quat_norm(const go_quat *q, go_quat *out)
{
    return pmQuatNorm(q, out) ? GO_RESULT_NORM_ERROR : GO_RESULT_OK;
}
static inline go_result go_quat_quat_mult(const go_quat *a, const go_quat *b, go_quat *out)
{
    return pmQuatQuatMult(a, b, out);
}
static inline go_result go_quat_cart_mult(const go_quat *q, const go_cart *v, go_cart *out)
{
    return pmQuatCartMult(q, v, out) ? GO_RESULT_NORM_ERROR : GO_RESULT_OK;
}
static inline go_result go_quat_mat_convert(const go_quat *q, go_mat *out)
{
    return pmQuatMatConvert(q, out) ? GO_RESULT_NORM_ERROR : GO_RESULT_OK;
}
static inline go_result go_mat_quat_convert(const go_mat *m, go_quat *out)
{
    return pmMatQuatConvert(m, out);
}
static inline go_result go_rpy_mat_convert(const go_rpy *a, go_mat *out)
{
    return pmRpyMatConvert(a, out);
}
static inline go_result go_mat_rpy_convert(const go_mat *m, go_rpy *out)
{
    return pmMatRpyConvert(m, out);
}
static inline go_result go_rpy_quat_convert(const go_rpy *a, go_quat *out)
{
    go_mat m;
    pmRpyMatConvert(a, &m);
    return pmMatQuatConvert(&m, out);
}
static inline go_result go_quat_rpy_convert(const go_quat *q, go_rpy *out)
{
    go_mat m;
    if (pmQuatMatConvert(q, &m))
        return GO_RESULT_NORM_ERROR;
    return pmMatRpyConvert(&m, out);
}

static inline go_mat go_mat_ident(void)
{
    return (go_mat){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}
static inline go_result go_mat_inv(const go_mat *m, go_mat *out) { return pmMatInv(m, out); }
static inline go_result go_mat_cart_mult(const go_mat *m, const go_cart *v, go_cart *out)
{
    return pmMatCartMult(m, v, out);
}
static inline go_result go_mat_mat_mult(const go_mat *a, const go_mat *b, go_mat *out)
{
    return pmMatMatMult(a, b, out);
}

static inline go_pose go_pose_this(go_real x, go_real y, go_real z, go_real rs, go_real rx,
                                   go_real ry, go_real rz)
{
    return (go_pose){{x, y, z}, {rs, rx, ry, rz}};
}
static inline go_pose go_pose_identity(void) { return go_pose_this(0, 0, 0, 1, 0, 0, 0); }
static inline go_result go_pose_cart_mult(const go_pose *p, const go_cart *v, go_cart *out)
{
    go_cart turned;
    if (pmQuatCartMult(&p->rot, v, &turned))
        return GO_RESULT_NORM_ERROR;
    return pmCartCartAdd(&p->tran, &turned, out);
}
static inline go_result go_pose_pose_mult(const go_pose *a, const go_pose *b, go_pose *out)
{
    go_pose both;
    const go_result code = go_pose_cart_mult(a, &b->tran, &both.tran);
    if (code != GO_RESULT_OK)
        return code;
    pmQuatQuatMult(&a->rot, &b->rot, &both.rot);
    *out = both;
    return GO_RESULT_OK;
}
static inline go_result go_pose_inv(const go_pose *p, go_pose *out)
{
    go_pose back;
    pmQuatInv(&p->rot, &back.rot);
    if (pmQuatCartMult(&back.rot, &p->tran, &back.tran))
        return GO_RESULT_NORM_ERROR;
    go_cart_neg(&back.tran, &back.tran);
    *out = back;
    return GO_RESULT_OK;
}
static inline go_result go_pose_hom_convert(const go_pose *p, go_hom *out)
{
    const go_cart tran = p->tran;
    if (pmQuatMatConvert(&p->rot, &out->rot))
        return GO_RESULT_NORM_ERROR;
    out->tran = tran;
    return GO_RESULT_OK;
}
static inline go_result go_hom_pose_convert(const go_hom *h, go_pose *out)
{
    const go_cart tran = h->tran;
    pmMatQuatConvert(&h->rot, &out->rot);
    out->tran = tran;
    return GO_RESULT_OK;
}
static inline go_result go_hom_inv(const go_hom *h, go_hom *out)
{
    go_hom back;
    pmMatInv(&h->rot, &back.rot);
    pmMatCartMult(&back.rot, &h->tran, &back.tran);
    go_cart_neg(&back.tran, &back.tran);
    *out = back;
    return GO_RESULT_OK;
}

/* A matrix of rows and columns whose numbers are in memory of the caller, row after row. Functions need no memory of
 * their own, so that realtime code may call them. */
typedef struct {
    go_integer rows, cols;
    go_real *el;
    /* As many numbers as el: go_matrix_inv works in it. */
    go_real *work;
} go_matrix;

#define GO_MATRIX_DECLARE(M, space, nrows, ncols) \
    go_matrix M = {0, 0, NULL, NULL};             \
    struct {                                      \
        go_real el[(nrows) * (ncols)];            \
        go_real work[(nrows) * (ncols)];          \
    } space
#define go_matrix_init(M, space, nrows, ncols) \
    ((M).rows = (nrows), (M).cols = (ncols), (M).el = (space).el, (M).work = (space).work)
#define GO_MATRIX_AT(M, row, col) ((M)->el[(row) * (M)->cols + (col)])

static inline go_result go_matrix_matrix_add(const go_matrix *a, const go_matrix *b, go_matrix *out)
{
    if (a->rows != b->rows || a->cols != b->cols || a->rows != out->rows || a->cols != out->cols)
        return GO_RESULT_BAD_ARGS;
    for (go_integer i = 0; i < a->rows * a->cols; i++)
        out->el[i] = a->el[i] + b->el[i];
    return GO_RESULT_OK;
}
static inline go_result go_matrix_matrix_copy(const go_matrix *a, go_matrix *out)
{
    if (a->rows != out->rows || a->cols != out->cols)
        return GO_RESULT_BAD_ARGS;
    for (go_integer i = 0; i < a->rows * a->cols; i++)
        out->el[i] = a->el[i];
    return GO_RESULT_OK;
}
/* The result is another matrix than the factors. */
static inline go_result go_matrix_matrix_mult(const go_matrix *a, const go_matrix *b, go_matrix *out)
{
    if (a->cols != b->rows || out->rows != a->rows || out->cols != b->cols || out->el == a->el ||
        out->el == b->el)
        return GO_RESULT_BAD_ARGS;
    for (go_integer r = 0; r < a->rows; r++)
        for (go_integer c = 0; c < b->cols; c++) {
            go_real sum = 0;
            for (go_integer k = 0; k < a->cols; k++)
                sum += GO_MATRIX_AT(a, r, k) * GO_MATRIX_AT(b, k, c);
            GO_MATRIX_AT(out, r, c) = sum;
        }
    return GO_RESULT_OK;
}
/* The result is another vector than v. */
static inline go_result go_matrix_vector_mult(const go_matrix *a, const go_real *v, go_real *out)
{
    if (v == out)
        return GO_RESULT_BAD_ARGS;
    for (go_integer r = 0; r < a->rows; r++) {
        out[r] = 0;
        for (go_integer k = 0; k < a->cols; k++)
            out[r] += GO_MATRIX_AT(a, r, k) * v[k];
    }
    return GO_RESULT_OK;
}
static inline go_result go_matrix_transpose(const go_matrix *a, go_matrix *out)
{
    if (out->rows != a->cols || out->cols != a->rows || out->el == a->el)
        return GO_RESULT_BAD_ARGS;
    for (go_integer r = 0; r < a->rows; r++)
        for (go_integer c = 0; c < a->cols; c++)
            GO_MATRIX_AT(out, c, r) = GO_MATRIX_AT(a, r, c);
    return GO_RESULT_OK;
}
/* Gauss and Jordan, with the largest pivot of each column. The result is another matrix than the argument. After
 * GO_RESULT_SINGULAR its numbers are meaningless. */
static inline go_result go_matrix_inv(const go_matrix *a, go_matrix *out)
{
    const go_integer n = a->rows;
    go_real *w = out->work;
    if (n != a->cols || out->rows != n || out->cols != n || out->el == a->el || w == NULL)
        return GO_RESULT_BAD_ARGS;
    for (go_integer i = 0; i < n * n; i++) {
        w[i] = a->el[i];
        out->el[i] = i % (n + 1) == 0;
    }
    for (go_integer c = 0; c < n; c++) {
        go_integer best = c;
        for (go_integer r = c + 1; r < n; r++)
            if (fabs(w[r * n + c]) > fabs(w[best * n + c]))
                best = r;
        const go_real pivot = w[best * n + c];
        if (!(fabs(pivot) > 0.0))
            return GO_RESULT_SINGULAR;
        for (go_integer k = 0; k < n; k++) {
            const go_real x = w[best * n + k], y = out->el[best * n + k];
            w[best * n + k] = w[c * n + k];
            out->el[best * n + k] = out->el[c * n + k];
            w[c * n + k] = x / pivot;
            out->el[c * n + k] = y / pivot;
        }
        for (go_integer r = 0; r < n; r++) {
            const go_real f = w[r * n + c];
            for (go_integer k = 0; r != c && k < n; k++) {
                w[r * n + k] -= f * w[c * n + k];
                out->el[r * n + k] -= f * out->el[c * n + k];
            }
        }
    }
    return GO_RESULT_OK;
}
#endif
