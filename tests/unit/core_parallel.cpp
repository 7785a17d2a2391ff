#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace halflight {
namespace {

TEST(SideBySide, EachWorkIsDoneOnceOnOneThreadWithItsLoops) {
  using namespace std::chrono_literals;
  constexpr size_t works = 20;
  std::vector<std::atomic<int>> done(works);
  std::atomic<int> strangers = 0;
  side_by_side(works, [&](size_t i) {
    ++done[i];
    const std::thread::id own = std::this_thread::get_id();
    // One goes on long after the others: their threads would come to its help.
    parallel_for(0, i == 0 ? 200 : 1, 1, [&](size_t, size_t) {
      std::this_thread::sleep_for(200us);
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
