// Filling a cut's arrays, for those who make cuts.
#pragma once

#include "lights/light_tree.h"

namespace halflight {

inline size_t padded_clusters(size_t clusters) { return (clusters + 15) / 16 * 16; }

/// Grows or shrinks all arrays of clusters; new ones have no power.
void resize_arrays(Cut&, size_t padded);
/// Makes cluster k of a node, all but its leaves' tables.
void set_cluster(Cut&, uint32_t k, const LightNode&);
/// Clusters [begin, end) of one cut, all but their leaves' guide, to those of another from `to_k` on.
void copy_clusters(const Cut& from, uint32_t begin, uint32_t end, Cut& to, uint32_t to_k);
/// Leaves' running sums and guide of cluster k, from `leaf_prefix`.
void set_leaf_ranges(Cut&, uint32_t k);

}  // namespace halflight
