// Pictures of techniques that follow rays do not hang on threads or on how a pass is cut up.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "support/traced_rooms.h"

namespace halflight {
namespace {

TEST(TracedTechniques, SameBitsForAnyNumberOfThreadsAndSubsets) {
  std::vector<GBufferTexel> pixels;
  for (int copy = 0; copy < 150; ++copy)
    for (const GBufferTexel& pixel : corner_pixels()) pixels.push_back(pixel);
  for (const char* id : {"mis", "brdf", "instant"}) {
    TracedScene s(full_room(), pixels, all_kinds);
    set_thread_count(1);
    const std::vector<Vec3> one = one_pass(s, *make_technique(s, id), 3, 9);
    for (const int threads : {2, 5}) {
      set_thread_count(threads);
      EXPECT_EQ(one_pass(s, *make_technique(s, id), 3, 9), one) << id;
    }
    set_thread_count(0);
    const auto technique = make_technique(s, id);
    Film parts(s.gbuffer.width, 1);
    for (uint32_t offset = 0; offset < 16; ++offset) {
      PassRequest request;
      request.pass = 3, request.samples = 9, request.half = 1, request.stride = 4, request.offset = offset;
      technique->run_pass(s.frame, request, parts);
    }
    for (uint32_t i = 0; i < one.size(); ++i) ASSERT_EQ(parts.radiance(i), one[i]) << id;
  }
}

}  // namespace
}  // namespace halflight
