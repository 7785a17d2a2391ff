// What a member of S, a pixel and a triangle cost in memory, as docs/performance.md states it: differences of
// what is allocated between two sizes, so that what does not grow drops out.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "benchmarks/generated_scenes.h"
#include "session.h"

namespace {

std::atomic<int64_t> live_bytes{0};

void* counted_allocation(std::size_t size, std::size_t alignment) {
  void* memory = nullptr;
  if (alignment <= alignof(std::max_align_t))
    memory = std::malloc(size > 0 ? size : 1);
  else if (posix_memalign(&memory, alignment, size) != 0)
    memory = nullptr;
  if (!memory) throw std::bad_alloc();
  live_bytes += static_cast<int64_t>(malloc_usable_size(memory));
  return memory;
}

void counted_release(void* memory) noexcept {
  if (memory) live_bytes -= static_cast<int64_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return counted_allocation(size, 1); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted_allocation(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { counted_release(memory); }
void operator delete(void* memory, std::size_t) noexcept { counted_release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { counted_release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { counted_release(memory); }

namespace halflight {
namespace {

// The figures of docs/performance.md, section "Memory"; bytes.
constexpr double bytes_a_light = 266, bytes_a_pixel = 204, bytes_a_triangle = 132;

struct Held {
  double bytes, units;
};

/// What is allocated when `make` has made what it returns, which tells the number of units.
template <class Make, class Units>
Held held_by(const Make& make, const Units& units) {
  const int64_t before = live_bytes;
  const auto made = make();
  return {static_cast<double>(live_bytes - before), units(*made)};
}

double bytes_a_unit(Held few, Held many) { return (many.bytes - few.bytes) / (many.units - few.units); }

std::unique_ptr<Session> room_session(size_t triangles, int width, int height, int points) {
  static Messages messages;
  RenderSettings settings;
  settings.technique = "bidirectional";
  settings.backend = Backend::none;
  settings.width = width, settings.height = height;
  settings.values.set("lights.count", std::to_string(points));
  auto session = std::make_unique<Session>(knot_room(triangles, Growth::mesh), settings, messages);
  session->run_pass(1, 1, 0);
  return session;
}

TEST(Memory, AMemberOfS) {
  const auto held = [](int points) {
    return held_by([=] { return room_session(1000, 64, 48, points); },
                   [](const Session& session) { return static_cast<double>(session.stats().light_count); });
  };
  held(1024);  // threads and their stacks of work are there from now on
  EXPECT_NEAR(bytes_a_unit(held(16384), held(65536)), bytes_a_light, 0.03 * bytes_a_light);
}

TEST(Memory, APixel) {
  const auto held = [](int width, int height) {
    return held_by(
        [=] { return room_session(1000, width, height, 1024); },
        [](const Session& session) { return static_cast<double>(session.gbuffer().pixel_count()); });
  };
  held(64, 48);
  EXPECT_NEAR(bytes_a_unit(held(160, 120), held(640, 480)), bytes_a_pixel, 0.03 * bytes_a_pixel);
}

TEST(Memory, ATriangle) {
  const auto held = [](size_t triangles) {
    const int64_t before = live_bytes;
    const auto session = room_session(triangles, 64, 48, 1024);
    return Held{
        static_cast<double>(live_bytes - before) + static_cast<double>(session->frame().rays->memory_bytes()),
        static_cast<double>(session->scene().triangles.size())};
  };
  held(1000);
  // Embree allocates in blocks: the more triangles, the nearer.
  EXPECT_NEAR(bytes_a_unit(held(50'000), held(400'000)), bytes_a_triangle, 0.1 * bytes_a_triangle);
}

}  // namespace
}  // namespace halflight
