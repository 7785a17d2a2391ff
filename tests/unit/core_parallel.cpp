#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace halflight {
namespace {

TEST(SideBySide, EachWorkIsDoneOnceOnOneThreadWithItsLoops) {
  constexpr size_t works = 200, steps = 5000;
  std::vector<std::atomic<int>> done(works);
  std::atomic<int> strangers = 0;
  side_by_side(works, [&](size_t i) {
    ++done[i];
    const std::thread::id own = std::this_thread::get_id();
    parallel_for(0, steps, 1, [&](size_t, size_t) {
      if (std::this_thread::get_id() != own) ++strangers;
    });
  });
  for (const std::atomic<int>& count : done) EXPECT_EQ(count, 1);
#if !defined(__SANITIZE_THREAD__)  // its loops are plain threads, that share everything
  EXPECT_EQ(strangers, 0);
#endif
}

TEST(SideBySide, NothingToDoIsDone) {
  side_by_side(0, [](size_t) { FAIL(); });
}

TEST(SideBySide, AnErrorComesOut) {
  EXPECT_THROW(side_by_side(10,
                            [](size_t i) {
                              if (i == 3) throw std::runtime_error("three");
                            }),
               std::runtime_error);
}

}  // namespace
}  // namespace halflight
