// --view files: what they say, and what is wrong with the wrong ones.
#include <gtest/gtest.h>

#include "core/errors.h"
#include "scene/built_in_scenes.h"
#include "scene/view_file.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

TEST(Views, ReadsEveryKey) {
  TemporaryFolder folder;
  const auto path = folder.write("view.json", R"({
    "camera": {"position": [1, 2, 3], "target": [1, 2, -5], "fov": 60},
    "lights": [
      {"type": "point", "name": "bulb", "position": [0, 1, 0], "color": [1, 0.5, 0], "intensity": 8, "range": 3},
      {"type": "spot", "position": [0, 4, 0], "target": [0, 0, 0], "up": [1, 0, 0], "inner": 10, "outer": 20, "picture": "a/s.hdr"},
      {"type": "directional", "direction": [0, -2, 0], "intensity": 5}],
    "environment": {"file": "sky.hdr", "rotation": 90, "strength": 0.5},
    "ev": -1.5})");
  const View view = read_view(path.string());
  ASSERT_TRUE(view.camera);
  EXPECT_EQ(view.camera->position, Vec3(1, 2, 3));
  EXPECT_NEAR(view.camera->back.z, 1, 1e-6);
  EXPECT_NEAR(view.camera->vertical_fov, pi / 3, 1e-6);
  ASSERT_EQ(view.lights.size(), 3u);
  EXPECT_EQ(view.lights[0].kind, PunctualKind::point);
  EXPECT_EQ(view.lights[0].name, "bulb");
  EXPECT_EQ(view.lights[0].intensity, Vec3(8, 4, 0));
  EXPECT_EQ(view.lights[0].range, 3);
  EXPECT_EQ(view.lights[1].direction, Vec3(0, -1, 0));
  EXPECT_NEAR(view.lights[1].up.x, 1, 1e-6);
  EXPECT_NEAR(view.lights[1].outer_cone, pi / 9, 1e-6);
  EXPECT_EQ(view.lights[1].picture, 0);
  ASSERT_EQ(view.slides.size(), 1u);
  EXPECT_EQ(view.slides[0], folder.path() / "a/s.hdr");
  EXPECT_EQ(view.lights[2].direction, Vec3(0, -1, 0));
  EXPECT_EQ(*view.environment->file, folder.path() / "sky.hdr");
  EXPECT_NEAR(*view.environment->rotation, pi / 2, 1e-6);
  EXPECT_EQ(*view.ev, -1.5f);
}

TEST(Views, ApplyAddsToTheScene) {
  TemporaryFolder folder;
  std::string sky = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
  for (int i = 0; i < 8 * 4; ++i) sky += static_cast<char>(128);
  folder.write("sky.hdr", sky);
  const auto path = folder.write("view.json", R"({
    "camera": {"position": [0, 0, 1], "target": [0, 0, 0]},
    "lights": [{"type": "spot", "position": [0, 4, 0], "target": [0, 0, 0], "picture": "sky.hdr"}],
    "environment": {"file": "sky.hdr", "strength": 3}})");
  Scene scene = make_cornell();
  scene.pictures.push_back(ImageRgb(1, 1));
  Messages messages;
  apply_view(scene, read_view(path, ""), {}, messages);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "view");
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].picture, 1);
  ASSERT_EQ(scene.pictures.size(), 2u);
  EXPECT_NEAR(scene.pictures[1].at(3, 1).x, 0.5f, 0.003f);
  EXPECT_TRUE(scene.environment.present());
  EXPECT_EQ(scene.environment.strength, 3);
}

TEST(Views, CollectionsAreReadByName) {
  TemporaryFolder folder;
  const std::string path =
      folder.write("views.json", R"({"views": {"one": {"ev": 1, "scene": "x/room.glb"}, "two": {"ev": 2}}})")
          .string();
  EXPECT_EQ(*read_view(path + "#two").ev, 2);
  EXPECT_EQ(*read_view(path + "#one").scene, folder.path() / "x/room.glb");
  for (const std::string& wrong : {path, path + "#tow"}) {
    try {
      read_view(wrong);
      ADD_FAILURE() << wrong;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_NE(std::string(error.what()).find("two"), std::string::npos) << error.what();
    }
  }
  const std::string single = folder.write("single.json", R"({"views": {"only": {"ev": 7}}})").string();
  EXPECT_EQ(*read_view(single).ev, 7);
}

struct Fault {
  const char* json;
  const char* words;  ///< the message must hold them
};

class ViewFaults : public testing::TestWithParam<Fault> {};

TEST_P(ViewFaults, NameThePlaceAndTheReason) {
  TemporaryFolder folder;
  const std::string path = folder.write("bad.json", GetParam().json).string();
  try {
    read_view(path);
    ADD_FAILURE() << "was read";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ExitCode::bad_input) << message;
    EXPECT_NE(message.find("bad.json"), std::string::npos) << message;
    EXPECT_NE(message.find(GetParam().words), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Views, ViewFaults,
    testing::Values(
        Fault{"{", "parse error"}, Fault{"[]", "must be an object"},
        Fault{"{\"camara\": {}}", "did you mean 'camera'"},
        Fault{R"({"camera": {"position": [0,0,0]}})", "camera: needs 'target'"},
        Fault{R"({"camera": {"position": [0,0,0], "target": [0,0,0]}})", "same point"},
        Fault{R"({"camera": {"position": [0,0], "target": [0,0,1]}})", "camera.position: must be an array"},
        Fault{R"({"camera": {"position": [0,0,0], "target": [0,0,1], "fov": 200}})", "camera.fov: must lie"},
        Fault{R"({"camera": {"position": [1e39,0,0], "target": [0,0,1]}})",
              "camera.position[0]: is too large"},
        Fault{R"({"lights": {}})", "lights: must be an array"},
        Fault{R"({"lights": [{"position": [0,0,0]}]})", "lights[0]: needs 'type'"},
        Fault{R"({"lights": [{"type": "sport", "position": [0,0,0]}]})", "did you mean 'spot'"},
        Fault{R"({"lights": [{"type": "point"}]})", "lights[0]: needs 'position'"},
        Fault{R"({"lights": [{"type": "spot", "position": [0,0,0]}]})", "either 'direction' or 'target'"},
        Fault{R"({"lights": [{"type": "point", "position": [0,0,0], "intensity": -1}]})",
              "lights[0].intensity"},
        Fault{R"({"lights": [{"type": "point", "position": [0,0,0], "range": 0}]})", "greater than 0"},
        Fault{
            R"({"lights": [{"type": "spot", "position": [0,0,0], "direction": [0,0,1], "inner": 40, "outer": 40}]})",
            "less than"},
        Fault{R"({"lights": [{"type": "directional", "direction": [0,0,0]}]})", "must not be zero"},
        Fault{R"({"lights": [{"type": "point", "position": [0,0,0], "picture": "a.hdr"}]})", "only a spot"},
        Fault{R"({"environment": {"file": "http://x/y.hdr"}})", "not an address"},
        Fault{R"({"ev": "bright"})", "ev: must be a number"}, Fault{R"({"ev": 1e999})", "number overflow"},
        Fault{R"({"views": []})", "views: must be an object"}));

TEST(Views, DeepNestingIsRefused) {
  TemporaryFolder folder;
  const std::string path =
      folder.write("deep.json", "{\"ev\": " + std::string(100000, '[') + std::string(100000, ']') + "}")
          .string();
  EXPECT_THROW(read_view(path), Error);
}

}  // namespace
}  // namespace halflight
