// Filling a cut's arrays, for those who make cuts.
#pragma once

#include "lights/light_tree.h"

namespace halflight {

inline size_t padded_clusters(size_t clusters) { return (clusters + 15) / 16 * 16; }

/// Grows or shrinks all arrays of clusters; new ones have no power.
void resize_arrays(Cut&, size_t padded);
/// Makes cluster k of a node, all but its leaves' range.
void set_cluster(Cut&, uint32_t k, const LightNode&);
/// Clusters [begin, end) of one cut to those of another, from `to_k` on, which has the same leaves.
void copy_clusters(const Cut& from, uint32_t begin, uint32_t end, Cut& to, uint32_t to_k);
/// Leaves [begin, end) of a cluster, as a cluster of their own.
LeafRange part_of_range(const Cut&, const LeafRange& whole, uint32_t begin, uint32_t end);

}  // namespace halflight
