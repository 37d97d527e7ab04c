/* Partitions of the rope into elements: EEM and TMN-ETM.

   EEM, the equal-length element mesh, is fixed on the rope: the baseline against which the other is checked.

   TMN-ETM, time-varying multi-segment non-equal-length elements, has seven segments with element lengths

       I: l    II: l/2    III: l/4    IV: l/8    V: l/4    VI: l/2    VII: l

   with IV around the loop's lowest point. For every l that the loop travels along the rope a transformation moves
   the pattern by l: segment I gains one element and VII loses one, or the reverse; the other counts stay. Where
   the pattern becomes coarser, elements merge; where it becomes finer, they split (see transfer). Without III and
   V the elements of IV are l/4 long, without II and VI too l/2: IV then covers less between transformations. Near
   an end of the rope the pattern continues beyond it. The outermost l stays, with the loop's elements where they
   are shorter. The part cut off by the end, up to half of the pattern, halves the other leg's longest elements:
   the number of elements stays.

   Two additions are ours. The outermost element at each end is halved towards the end ``end_levels`` times and
   stays so: the rope is clamped there with a vertical tangent, and the bending layer below the clamp, sqrt(EI /
   T) = 0.2 to 0.5 m long, is shorter than l; unresolved, it leans the whole leg. And in I and VII the pattern
   continues upwards with 2 l, 3 l, 4 l, 6 l ..., as far as the distances from end and loop allow: the tension
   grows with the distance x from the loop, so waves of a swaying leg travel at sqrt(g x). An element may be as
   long as sqrt(``grading_length`` x). Their number is the same for every position of the loop and grows with the
   root of the rope's length for a given ``grading_length``.

   Where a leg faces a divider that may press it, MESH_PATTERN_WINDOW elements of l are divided into
   MESH_PATTERN_WINDOW_PARTS each. */

#include "partition.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "messages.h"
#include "parameter_table.h"
#include "rope.h"
#include "rules.h"
#include "state_structures.h"

static const int LONGER[] = MESH_PATTERN_LEG_LENGTHS;
enum { LENGTHS = sizeof LONGER / sizeof *LONGER };

static int as_int(double x) {
    return x < INT_MAX ? (int)x : INT_MAX;
}

double partition_fine_length(const Pattern *pattern, const double *lengths) {
    return pattern->coarse > 0 ? mesh_pattern_fine_share(pattern->counts + 1) * pattern->coarse : lengths[0];
}

Mesh fit_mesh(const Scene *scene) {
    Mesh mesh = scene->mesh;
    if (mesh.kind != AUTO_MESH) return mesh;
    const double asked = mesh.loop_error > 0 ? mesh.loop_error : MESH_SHARE * scene->accuracy.loop;
    const FittedMesh fitted = fit_elements(scene, asked, log10(MESH_FIT_COVER_ERROR / asked));
    mesh.kind = fitted.equal > 0 ? EEM : TMN;
    mesh.loop_error = 0; /* not used by these kinds */
    mesh.lateral_frequency = 0;
    if (mesh.kind == EEM)
        mesh.elements = as_int(fitted.equal);
    else {
        const int counts[] = {2, 0, as_int(fitted.fine), 0, 2};
        memcpy(mesh.counts, counts, sizeof counts);
        mesh.coarse_length = fitted.coarse;
        mesh.end_levels = (int)fitted.end_levels;
        mesh.grading_length = fitted.grading;
    }
    return mesh;
}

/* Return the length of the element that begins at `begin` of a leg, in units of l: the longest of LONGER that the
   distances from its end and from the loop and `growth` allow, where its multiples lie; else 1. */
static int element_length(int begin, int units, double growth) {
    int size = 1;
    if (!(growth > 0)) return size;
    for (int k = 0; k < LENGTHS; k++) {
        const int longer = LONGER[k], gap = units - (begin + longer);
        const bool near_end = longer > begin;
        const bool near_loop = gap < MESH_PATTERN_GRADING * (longer - 1);
        if (near_end || near_loop || gap * growth < (double)(longer * longer)) break;
        if (begin % longer == 0) size = longer;
    }
    return size;
}

/* Write the element lengths of a leg from the end of the rope on, as long as `growth` allows at their distances from
   end and loop; return their number.  Leg, growth and lengths are in units of l; lengths may be NULL. */
static int leg_lengths(int units, double growth, double *lengths, int stride) {
    int count = 0;
    int begin = 0;
    while (begin < units) {
        const int size = element_length(begin, units, growth);
        if (lengths != NULL) lengths[(ptrdiff_t)stride * count] = size;
        begin += size;
        count++;
    }
    return count;
}

/* Return the number of elements of both legs, which have `units` l together, for the worst place of the loop. */
static int leg_elements(int units, double growth) {
    if (!(growth > 0)) return units; /* all are l long */
    int most = 0;
    for (int first = 1; first <= units / 2; first++) {
        int count = leg_lengths(first, growth, NULL, 0) + leg_lengths(units - first, growth, NULL, 0);
        most = count > most ? count : most;
    }
    return most;
}

/* Return the index of the longest element except the outermost, nearest to the loop among equals; 0 for none. */
static int longest_of(const double *lengths, int stride, int count) {
    int found = count > 1;
    for (int k = 2; k < count; k++)
        if (lengths[(ptrdiff_t)stride * k] >= lengths[(ptrdiff_t)stride * found]) found = k;
    return found;
}

/* True if element k of this leg, from its end on, is in a window. */
static bool in_window(const int *windows, int side, int k) {
    for (int i = side; i < DIVIDERS; i += 2)
        if (0 <= k - windows[i] && k - windows[i] < MESH_PATTERN_WINDOW) return true;
    return false;
}

/* Divide element k of `count` into equal parts. */
static void divide(double *lengths, int stride, int count, int k, int parts) {
    const double each = lengths[(ptrdiff_t)stride * k] / parts;
    for (int i = count - 1; i > k; i--) lengths[(ptrdiff_t)stride * (i + parts - 1)] = lengths[(ptrdiff_t)stride * i];
    for (int i = k; i < k + parts; i++) lengths[(ptrdiff_t)stride * i] = each;
}

/* Write both legs from their ends on; return the number of elements on the left.  Spare elements refine first the
   windows, then the longest elements, never the outermost. */
static int both_leg_lengths(int first, int last, double growth, int elements, const int *windows, double *left,
                            double *right) {
    int counts[2] = {leg_lengths(first, growth, left, 1), leg_lengths(last, growth, right, -1)};
    int spare = elements - counts[0] - counts[1];
    for (int side = 0; side < 2; side++)
        for (int k = counts[side] - 1; k > 0; k--)
            if (spare >= MESH_PATTERN_WINDOW_PARTS - 1 && in_window(windows, side, k)) {
                divide(side ? right : left, side ? -1 : 1, counts[side], k, MESH_PATTERN_WINDOW_PARTS);
                counts[side] += MESH_PATTERN_WINDOW_PARTS - 1;
                spare -= MESH_PATTERN_WINDOW_PARTS - 1;
            }
    for (; spare > 0; spare--) {
        int i = longest_of(left, 1, counts[0]), j = longest_of(right, -1, counts[1]);
        int side = i == 0 || (j > 0 && right[-j] > left[i]);
        divide(side ? right : left, side ? -1 : 1, counts[side], side ? j : i, 2);
        counts[side]++;
    }
    return counts[0];
}

/* Return the number of elements in segments I and VII together, for l near coarse_length. */
static double outer_of(const Mesh *mesh, double length) {
    return elementary_nearest_whole(length / mesh->coarse_length - mesh_pattern_inner_length(mesh->counts));
}

int partition_elements(const Mesh *mesh, double length, const double *divider_s, char *message) {
    message[0] = '\0';
    if (mesh->kind == EEM) {
        return require_in_bounds(mesh, message) ? mesh->elements : 0; /* an automatic mesh may be out of bounds */
    }
    double outer = outer_of(mesh, length);
    if (outer > (double)MAX_ELEMENTS)
        return say_too_many_lengths(message, mesh->coarse_length, length, outer, MAX_ELEMENTS);
    if (!(outer >= 2))
        return say_too_few_lengths(message, mesh_pattern_inner_length(mesh->counts) * mesh->coarse_length, length);
    double growth = mesh->grading_length / (length / (outer + mesh_pattern_inner_length(mesh->counts)));
    double elements = leg_elements((int)outer, growth) + 2 * mesh->end_levels;
    for (int k = 0; k < SEGMENTS - 2; k++) elements += mesh->counts[k];
    for (int i = 0; i < DIVIDERS; i++)
        elements += isfinite(divider_s[i]) ? MESH_PATTERN_WINDOW * (MESH_PATTERN_WINDOW_PARTS - 1) : 0;
    if (elements > (double)MAX_ELEMENTS) return say_too_many_elements(message, elements, MAX_ELEMENTS);
    return (int)elements;
}

/* Write the lengths (or NULL) of segments II to VI as far as the rope reaches, in units of l; return their number. */
static int fill_inner(const int *counts, double *lengths) {
    const double relative[SEGMENTS] = {1, 0.5, 0.25, mesh_pattern_fine_share(counts + 1), 0.25, 0.5, 1};
    const double inner = mesh_pattern_inner_length(counts + 1);
    const double begin = fmax(1 - counts[0], 0), end = inner - fmax(1 - counts[SEGMENTS - 1], 0);
    double reached = 0;
    int n = 0;
    for (int segment = 1; segment < SEGMENTS - 1; segment++)
        for (int k = 0; k < counts[segment]; k++) {
            const double from = fmax(reached, begin), to = fmin(reached + relative[segment], end);
            reached += relative[segment];
            if (!(to > from)) continue;
            if (lengths != NULL) lengths[n] = to - from;
            n++;
        }
    return n;
}

/* Write the lengths of the outermost coarse element, refined towards the end: 2^-levels twice, ..., 1/4, 1/2 of it,
   each divided to at most `longest`; return the number of elements. */
static int end_lengths(int levels, double longest, double *lengths, int stride) {
    int n = 0;
    for (int k = 0; k <= levels; k++) {
        const double size = ldexp(1.0, k == 0 ? -levels : k - 1 - levels), each = fmin(size, longest);
        for (double begin = 0; begin < size; begin += each, n++)
            if (lengths != NULL) lengths[(ptrdiff_t)stride * n] = each;
    }
    return n;
}

/* Return the number of elements that both legs share, and that of each end's refinement, without its outermost. */
static int elements_of_legs(int elements, const int *counts, int levels, const double longest[2], int ends[2]) {
    for (int side = 0; side < 2; side++) ends[side] = end_lengths(levels, longest[side], NULL, 0) - 1;
    return elements - ends[0] - ends[1] - fill_inner(counts, NULL);
}

static void tmn_lengths(const Pattern *pattern, int elements, double *lengths) {
    double coarse = pattern->coarse;
    const int *counts = pattern->counts;
    int first = counts[0] > 1 ? counts[0] : 1, last = counts[SEGMENTS - 1] > 1 ? counts[SEGMENTS - 1] : 1;
    const double growth = pattern->grading_length / coarse, fine = mesh_pattern_fine_share(counts + 1);
    const int levels = pattern->end_levels,
              least = leg_lengths(first, growth, NULL, 0) + leg_lengths(last, growth, NULL, 0);
    /* Where the pattern is cut off, the loop bends the rope up to its end. */
    double longest[2] = {counts[0] < 1 ? fine : 1, counts[SEGMENTS - 1] < 1 ? fine : 1};
    int ends[2];
    int both = elements_of_legs(elements, counts, levels, longest, ends);
    if (both < least) { /* too few are left for the legs: do not refine the ends for the loop */
        longest[0] = longest[1] = 1;
        both = elements_of_legs(elements, counts, levels, longest, ends);
    }

    double *left = lengths + ends[0];
    double *right = lengths + elements - 1 - ends[1];
    fill_inner(counts, left + both_leg_lengths(first, last, growth, both, pattern->windows, left, right));
    end_lengths(levels, longest[0], lengths, 1);
    end_lengths(levels, longest[1], lengths + elements - 1, -1);
    for (int k = 0; k < elements; k++) lengths[k] *= coarse;
}

void mesh_dividers(const Scene *scene, double left, double right, double *divider_s) {
    mesh_fit_divider_positions(scene, left, right, divider_s);
    if (scene->mesh.kind == AUTO_MESH) return;
    for (int i = 0; i < DIVIDERS; i++) divider_s[i] = INFINITY;
}

static void place_windows(Pattern *pattern, const double *divider_s) {
    for (int i = 0; i < DIVIDERS; i++)
        pattern->windows[i] = (int)elementary_nearest_whole(mesh_pattern_window_place(pattern, divider_s[i]));
}

bool window_due(const Pattern *pattern, const double *divider_s) {
    if (!(pattern->coarse > 0)) return false; /* EEM has no windows */
    for (int i = 0; i < DIVIDERS; i++)
        if (fabs(mesh_pattern_window_place(pattern, divider_s[i]) - pattern->windows[i]) > MESH_PATTERN_WINDOW_DUE)
            return true;
    return false;
}

void partition(const Mesh *mesh, double length, double bottom_s, const double *divider_s, int elements,
               Pattern *pattern, double *lengths) {
    memset(pattern, 0, sizeof *pattern);
    if (mesh->kind == EEM) {
        for (int k = 0; k < mesh->elements; k++) lengths[k] = length / mesh->elements;
        return;
    }
    double inner = mesh_pattern_inner_length(mesh->counts), outer = outer_of(mesh, length);
    double coarse = length / (outer + inner);
    double first = elementary_nearest_whole(bottom_s / coarse - 0.5 * inner),
           least = mesh_pattern_min_outer(mesh->counts);
    first = first > least ? fmin(first, outer - least) : least;
    pattern->coarse = coarse;
    pattern->end_levels = mesh->end_levels;
    pattern->grading_length = mesh->grading_length;
    pattern->counts[0] = (int)first;
    for (int k = 0; k < SEGMENTS - 2; k++) pattern->counts[k + 1] = mesh->counts[k];
    pattern->counts[SEGMENTS - 1] = (int)(outer - first);
    place_windows(pattern, divider_s);
    tmn_lengths(pattern, elements, lengths);
}

void partition_transform(Pattern *pattern, int direction, const double *divider_s, int elements, double *lengths) {
    pattern->counts[0] += direction;
    pattern->counts[SEGMENTS - 1] -= direction;
    place_windows(pattern, divider_s);
    tmn_lengths(pattern, elements, lengths);
}

void arc_lengths(int elements, const double *lengths, double *s) {
    s[0] = 0.0;
    for (int k = 0; k < elements; k++) s[k + 1] = s[k] + lengths[k];
}
