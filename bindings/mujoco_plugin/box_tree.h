/* A tree of boxes: which of many things may a ray meet? Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_BOX_TREE_H
#define CF_MUJOCO_PLUGIN_BOX_TREE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  double low[3];  // [m], world
  double high[3];
} cf_box_t;

typedef struct {
  cf_box_t box;
  int32_t  right;  // inner node: the other child, one is the next node; leaf: 0
  int32_t  first;  // leaf: in `order`
  int32_t  count;  // of a leaf
} cf_box_node_t;

typedef struct {
  int            node_count;
  cf_box_node_t *nodes;
  int32_t       *order;  // indices of the things, leaf by leaf
} cf_box_tree_t;

// Builds the tree over `count` >= 0 boxes. Returns false when there is no memory; otherwise it must
// be freed.
bool cf_box_tree_new(cf_box_tree_t *tree, const cf_box_t *boxes, int count);
void cf_box_tree_free(cf_box_tree_t *tree);

// Calls `meet` for each thing whose box the ray may meet nearer than `reach`; it returns the
// distance of the thing, or `reach` or more. Returns the nearest, or `reach`.
double cf_box_tree_ray(const cf_box_tree_t *tree, const double point[3], const double direction[3],
                       double reach, double (*meet)(const void *context, int thing, double reach),
                       const void *context);

#endif  // CF_MUJOCO_PLUGIN_BOX_TREE_H
