// The pass of GPU Gems 3, chapter 20: light of the environment at each pixel of the G-buffer, from samples of
// its BRDF looked up in filtered maps. Private to this folder.
#pragma once

#include "raster/filtered_environment.h"
#include "raster/gbuffer_pass.h"

namespace halflight {

class FilteredLight {
 public:
  explicit FilteredLight(GlContextBase&);

  /// Makes the maps and harmonics of the scene's environment; nothing is done where they stand.
  void prepare(const Environment&, int map_size);

  size_t bytes() const;  ///< of the maps

  /// Light of one subset of the pixels of the G-buffer drawn last, row by row. Needs `prepare`.
  FilteredResult light(const GpuScene&, const Environment&, const GBufferPass&, const FilteredRequest&);

 private:
  void bind(const GpuScene&, const Environment&, const GBufferPass&, const FilteredRequest&);

  GlContextBase& context_;
  GlProgram program_;
  GlName maps_, harmonics_;
  int map_size_ = 0;
};

}  // namespace halflight
