#include "mujoco_plugin/box_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAF 4    // things that share a leaf
#define DEPTH 64  // halving 2^31 things takes 31

static const double SLACK = 1e-9;  // [m], for rounding in the test of a box

typedef struct {
  double  center;
  int32_t thing;
} sort_key_t;

typedef struct {
  cf_box_tree_t  *tree;
  const cf_box_t *boxes;
  sort_key_t     *keys;
} builder_t;

static int by_center(const void *a, const void *b) {
  const sort_key_t *x = a, *y = b;
  if (x->center != y->center) {
    return x->center < y->center ? -1 : 1;
  }
  return x->thing < y->thing ? -1 : x->thing > y->thing;
}

static cf_box_t box_around(const builder_t *builder, int first, int count) {
  cf_box_t all = builder->boxes[builder->tree->order[first]];
  for (int i = first + 1; i < first + count; i++) {
    const cf_box_t *box = &builder->boxes[builder->tree->order[i]];
    for (int k = 0; k < 3; k++) {
      all.low[k]  = fmin(all.low[k], box->low[k]);
      all.high[k] = fmax(all.high[k], box->high[k]);
    }
  }
  return all;
}

static void sort_along_longest(const builder_t *builder, const cf_box_t *around, int first,
                               int count) {
  int axis = 0;
  for (int k = 1; k < 3; k++) {
    const double longest = around->high[axis] - around->low[axis];
    axis                 = around->high[k] - around->low[k] > longest ? k : axis;
  }
  int32_t *order = builder->tree->order + first;
  for (int i = 0; i < count; i++) {
    const cf_box_t *box = &builder->boxes[order[i]];
    builder->keys[i] = (sort_key_t){.center = box->low[axis] + box->high[axis], .thing = order[i]};
  }
  qsort(builder->keys, (size_t)count, sizeof *builder->keys, by_center);
  for (int i = 0; i < count; i++) {
    order[i] = builder->keys[i].thing;
  }
}

// Depth first, so that one child of a node is the next one. Half of the things on each side: the
// depth is that of the logarithm.
static void build(const builder_t *builder, int first, int count) {
  cf_box_node_t *node = &builder->tree->nodes[builder->tree->node_count++];
  *node = (cf_box_node_t){.box = box_around(builder, first, count), .first = first, .count = count};
  if (count <= LEAF) {
    return;
  }
  sort_along_longest(builder, &node->box, first, count);
  node->count = 0;
  build(builder, first, count / 2);
  node->right = builder->tree->node_count;
  build(builder, first + count / 2, count - count / 2);
}

bool cf_box_tree_new(cf_box_tree_t *tree, const cf_box_t *boxes, int count) {
  *tree = (cf_box_tree_t){.node_count = 0};
  if (count == 0) {
    return true;
  }
  tree->nodes      = calloc(2 * (size_t)count, sizeof *tree->nodes);
  tree->order      = calloc((size_t)count, sizeof *tree->order);
  sort_key_t *keys = calloc((size_t)count, sizeof *keys);
  // no test runs out of memory
  if (tree->nodes == NULL || tree->order == NULL || keys == NULL) {
    free(keys);
    cf_box_tree_free(tree);
    return false;
  }
  for (int i = 0; i < count; i++) {
    tree->order[i] = i;
  }
  const builder_t builder = {.tree = tree, .boxes = boxes, .keys = keys};
  build(&builder, 0, count);
  free(keys);
  return true;
}

void cf_box_tree_free(cf_box_tree_t *tree) {
  free(tree->nodes);
  free(tree->order);
  *tree = (cf_box_tree_t){.node_count = 0};
}

// Whether the ray passes through the box nearer than `reach`. Along an axis that the ray does not
// move on, the inverse is infinite and 0 times it no number, which fmin and fmax leave out.
static bool may_meet(const cf_box_t *box, const double point[3], const double inverse[3],
                     double reach) {
  double near = 0.0;
  double far  = reach;
  for (int k = 0; k < 3; k++) {
    const double a = (box->low[k] - SLACK - point[k]) * inverse[k];
    const double b = (box->high[k] + SLACK - point[k]) * inverse[k];
    near           = fmax(near, fmin(a, b));
    far            = fmin(far, fmax(a, b));
  }
  return near <= far;
}

double cf_box_tree_ray(const cf_box_tree_t *tree, const double point[3], const double direction[3],
                       double reach, double (*meet)(const void *context, int thing, double reach),
                       const void *context) {
  if (tree->node_count == 0) {
    return reach;
  }
  const double inverse[3] = {1.0 / direction[0], 1.0 / direction[1], 1.0 / direction[2]};
  int32_t      waiting[DEPTH];
  int          count = 0;
  waiting[count++]   = 0;
  while (count > 0) {
    const int32_t        i    = waiting[--count];
    const cf_box_node_t *node = &tree->nodes[i];
    if (!may_meet(&node->box, point, inverse, reach)) {
      continue;
    }
    for (int k = node->first; k < node->first + node->count; k++) {
      reach = fmin(reach, meet(context, tree->order[k], reach));
    }
    if (node->count == 0) {
      waiting[count++] = node->right;
      waiting[count++] = i + 1;
    }
  }
  return reach;
}
