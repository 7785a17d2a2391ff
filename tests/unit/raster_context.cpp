#include "unit/raster_scenes.h"

namespace halflight {
namespace {

using namespace test;

TEST(GlContext, EglAndOsMesaDescribeThemselves) {
  int found = 0;
  for (const Backend backend : {Backend::egl, Backend::osmesa}) {
    const auto context = context_or_null(backend);
    if (!context) continue;
    ++found;
    const GlDescription& description = context->description();
    EXPECT_EQ(description.backend, backend == Backend::egl ? "egl" : "osmesa");
    EXPECT_FALSE(description.renderer.empty());
    EXPECT_GE(description.version, "4.3");
    EXPECT_TRUE(description.software || backend == Backend::egl);
  }
  if (found == 0) GTEST_SKIP() << "neither libEGL nor libOSMesa is installed";
}

TEST(GlContext, AutomaticMakesOne) {
  try {
    const auto context = GlContext::make_headless(Backend::automatic);
    EXPECT_FALSE(context->description().version.empty());
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::no_gl);
    GTEST_SKIP() << error.what();
  }
}

TEST(GlContext, AWindowWithoutADisplayIsExitCodeFourAndSaysWhy) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  try {
    GlContext::make_headless(Backend::window);
    FAIL() << "a window without a display";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::no_gl);
    EXPECT_NE(std::string(error.what()).find("window: "), std::string::npos) << error.what();
  }
}

TEST(GlContext, AdoptingNothingIsAnError) {
  try {
    GlContext::adopt([](const char*) -> void* { return nullptr; });
    FAIL() << "no context is current";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::no_gl);
  }
}

}  // namespace
}  // namespace halflight
