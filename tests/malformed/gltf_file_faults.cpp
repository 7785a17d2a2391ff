// Faults of files rather than of what they describe: containers, JSON text, URIs, images.
#include <gtest/gtest.h>

#include "support/gltf_fixture.h"
#include "support/png_fixture.h"

namespace halflight {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

void expect_refused(const LoadOutcome& outcome, std::string_view told) {
  EXPECT_EQ(static_cast<int>(outcome.exit), 3) << outcome.all();
  EXPECT_TRUE(outcome.tells(told)) << "not told: " << told << "\n" << outcome.all();
}

LoadOutcome outcome_of_text(const std::string& name, const std::string& text,
                            const LoadOptions& options = {}) {
  const TemporaryFolder folder;
  return load_outcome(folder.write(name, text), options);
}

// ---- Containers ----

TEST(GlbFault, SoundOneLoads) {
  const LoadOutcome outcome = outcome_of_text("a.glb", triangle_fixture().glb());
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  EXPECT_EQ(outcome.scene.triangles.size(), 1u);
}

TEST(GlbFault, EveryTruncationIsRefused) {
  const std::string whole = triangle_fixture().glb();
  const TemporaryFolder folder;
  for (size_t size = 0; size < whole.size(); size += 7) {
    const LoadOutcome outcome = load_outcome(folder.write("a.glb", whole.substr(0, size)));
    expect_refused(outcome, "GLB_");
  }
}

TEST(GlbFault, EveryTruncationWithAMatchingLengthIsRefusedOrSound) {
  std::string whole = triangle_fixture().glb();
  const TemporaryFolder folder;
  for (size_t size = 12; size < whole.size(); ++size) {
    std::string cut = whole.substr(0, size);
    cut.replace(8, 4, GltfFixture::word(static_cast<uint32_t>(size)));
    EXPECT_EQ(static_cast<int>(load_outcome(folder.write("a.glb", cut)).exit), 3) << size;
  }
}

TEST(GlbFault, HeadersAreChecked) {
  const std::string whole = triangle_fixture().glb();
  const auto patched = [&](size_t at, const std::string& bytes) {
    std::string text = whole;
    return outcome_of_text("a.glb", text.replace(at, bytes.size(), bytes));
  };
  expect_refused(patched(0, "glTX"), "GLB_INVALID_MAGIC");
  expect_refused(patched(4, GltfFixture::word(1)), "GLB_INVALID_VERSION");
  expect_refused(patched(4, GltfFixture::word(3)), "GLB_INVALID_VERSION");
  expect_refused(patched(8, GltfFixture::word(12)), "GLB_LENGTH_TOO_SMALL");
  expect_refused(patched(8, GltfFixture::word(0xffffffffu)), "GLB_LENGTH_MISMATCH");
  expect_refused(patched(12, GltfFixture::word(0xfffffffcu)), "GLB_CHUNK_TOO_BIG");
  expect_refused(patched(12, GltfFixture::word(21)), "GLB_CHUNK_LENGTH_UNALIGNED");
  expect_refused(patched(16, "JSUN"), "GLB_UNEXPECTED_FIRST_CHUNK");
}

TEST(GlbFault, NoBinChunk) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["buffers"] = {{{"byteLength", gltf.bytes.size()}}};
  gltf.bytes.clear();
  std::string file = gltf.glb();
  file.resize(file.size() - 8);
  file.replace(8, 4, GltfFixture::word(static_cast<uint32_t>(file.size())));
  expect_refused(outcome_of_text("a.glb", file), "BUFFER_MISSING_GLB_DATA");
}

TEST(GlbFault, BinChunkShorterThanTheBuffer) {
  GltfFixture gltf = triangle_fixture();
  gltf.json["buffers"] = {{{"byteLength", 100}}};
  expect_refused(outcome_of_text("a.glb", gltf.glb()), "BUFFER_BYTE_LENGTH_MISMATCH");
}

// ---- JSON ----

TEST(JsonFault, NestingIsMeasuredBeforeParsing) {
  const auto nested = [](size_t depth) {
    return R"({"asset":{"version":"2.0"},"extras":)" + std::string(depth - 1, '[') +
           std::string(depth - 1, ']') + "}";
  };
  EXPECT_EQ(outcome_of_text("a.gltf", nested(256)).exit, ExitCode::ok);
  expect_refused(outcome_of_text("a.gltf", nested(257)), "nested deeper than 256 (--limit-json-depth)");
  expect_refused(outcome_of_text("a.gltf", nested(5'000'000)), "nested deeper");
  expect_refused(outcome_of_text("a.gltf", std::string(5'000'000, '[')), "nested deeper");
  // Brackets inside strings are none.
  EXPECT_EQ(outcome_of_text("a.gltf",
                            R"({"asset":{"version":"2.0"},"extras":")" + std::string(1000, '[') + R"(\"[["})")
                .exit,
            ExitCode::ok);
}

TEST(JsonFault, SyntaxIsRefused) {
  expect_refused(outcome_of_text("a.gltf", ""), "empty");
  expect_refused(outcome_of_text("a.gltf", "{"), "INVALID_JSON: syntax error at byte");
  expect_refused(outcome_of_text("a.gltf", "[]"), "TYPE_MISMATCH");
  expect_refused(outcome_of_text("a.gltf", "{\"asset\":{\"version\":\"\xff\xfe\"}}"), "INVALID_JSON");
  expect_refused(outcome_of_text("a.gltf", R"({"asset":{"version":"2.0"},"extras":1e999})"), "INVALID_JSON");
  expect_refused(outcome_of_text("a.gltf", "#?RADIANCE\n"), "INVALID_JSON");
}

TEST(JsonFault, ByteOrderMarkIsToldAndSkipped) {
  const LoadOutcome outcome = outcome_of_text("a.gltf", "\xef\xbb\xbf" + triangle_fixture().text());
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  EXPECT_TRUE(outcome.tells("byte order mark"));
}

// ---- URIs ----

/// A folder `asset` beside a folder `outside` that holds the triangle's bytes.
class UriFault : public testing::Test {
 protected:
  UriFault() {
    fs::create_directories(folder_.path() / "asset" / "inner");
    fs::create_directories(folder_.path() / "outside");
    const std::string bytes(gltf_.bytes.begin(), gltf_.bytes.end());
    folder_.write("outside/triangle.bin", bytes);
    folder_.write("asset/with space.bin", bytes);
    folder_.write("asset/inner/triangle.bin", bytes);
    fs::create_symlink(folder_.path() / "outside" / "triangle.bin", folder_.path() / "asset" / "link.bin");
    fs::create_directory_symlink(folder_.path() / "outside", folder_.path() / "asset" / "linked");
    fs::create_symlink("inner/triangle.bin", folder_.path() / "asset" / "inside.bin");
  }

  LoadOutcome open(const std::string& uri, bool allow_external = false) {
    gltf_.json["buffers"] = {{{"byteLength", gltf_.bytes.size()}, {"uri", uri}}};
    LoadOptions options;
    options.allow_external = allow_external;
    return load_outcome(folder_.write("asset/test.gltf", gltf_.text()), options);
  }

  TemporaryFolder folder_;
  GltfFixture gltf_ = triangle_fixture();
};

TEST_F(UriFault, InsideTheFolderOpens) {
  for (const char* uri : {"with space.bin", "with%20space.bin", "inner/triangle.bin",
                          "./inner/../inner/triangle.bin", "inside.bin", "inner%2Ftriangle.bin"}) {
    const LoadOutcome outcome = open(uri);
    EXPECT_EQ(outcome.exit, ExitCode::ok) << uri << ": " << outcome.message;
    EXPECT_EQ(outcome.scene.triangles.size(), 1u);
  }
}

TEST_F(UriFault, LeavingTheFolderIsRefusedUnlessAllowed) {
  const std::string absolute = (folder_.path() / "outside" / "triangle.bin").string();
  for (const std::string& uri :
       {std::string("../outside/triangle.bin"), std::string("%2e%2e/outside/triangle.bin"),
        std::string("inner/../../outside/triangle.bin"), std::string("..%2Foutside%2Ftriangle.bin"), absolute,
        std::string("link.bin"), std::string("linked/triangle.bin")}) {
    expect_refused(open(uri), "leaves the asset's folder (--allow-external opens it)");
    EXPECT_EQ(open(uri, true).exit, ExitCode::ok) << uri;
  }
}

TEST_F(UriFault, SchemesAreNeverFetched) {
  const std::string absolute = (folder_.path() / "outside" / "triangle.bin").string();
  for (const std::string& uri :
       {std::string("http://localhost/a.bin"), std::string("HTTPS://localhost/a.bin"), "file://" + absolute,
        "file:" + absolute, std::string("ftp:a.bin"), std::string(":")}) {
    expect_refused(open(uri), "INVALID_URI");
    expect_refused(open(uri, true), "INVALID_URI");
  }
}

TEST_F(UriFault, WhatIsNoFileIsRefused) {
  expect_refused(open("missing.bin"), "buffers[0].uri: IO_ERROR");
  expect_refused(open("inner"), "IO_ERROR");
  expect_refused(open(""), "INVALID_URI");
  expect_refused(open("a%00.bin"), "INVALID_URI");
}

TEST_F(UriFault, ShortFileIsRefused) {
  folder_.write("asset/short.bin", "abc");
  expect_refused(open("short.bin"),
                 "buffers[0].byteLength: BUFFER_BYTE_LENGTH_MISMATCH: 42 bytes declared, there are 3");
}

TEST_F(UriFault, DataUris) {
  expect_refused(open("data:"), "INVALID_URI");
  expect_refused(open("data:application/octet-stream;base64,@@@@"), "INVALID_URI: not valid base64");
  expect_refused(open("data:application/octet-stream;base64,AAAA"), "BUFFER_BYTE_LENGTH_MISMATCH");
  expect_refused(open("data:application/octet-stream;base64," + std::string(4000, 'A')),
                 "BUFFER_BYTE_LENGTH_MISMATCH: the data: URI has 3000 bytes, 45 are declared");
}

// ---- Images ----

GltfFixture textured_triangle() {
  GltfFixture gltf = triangle_fixture();
  gltf.primitive()["attributes"]["TEXCOORD_0"] = gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  gltf.primitive()["material"] = 0;
  gltf.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  gltf.json["textures"] = {{{"source", 0}}};
  return gltf;
}

LoadOutcome with_image(const std::vector<uint8_t>& bytes, bool strict = false,
                       const LoadOptions& options = {}) {
  GltfFixture gltf = textured_triangle();
  gltf.json["images"] = {{{"bufferView", gltf.add_view(bytes)}, {"mimeType", "image/png"}}};
  return load_outcome(gltf, options, strict);
}

void expect_placeholder(const LoadOutcome& outcome, std::string_view told) {
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.all();
  EXPECT_EQ(outcome.scene.triangles.size(), 1u);
  EXPECT_TRUE(outcome.scene.images.empty());
  ASSERT_FALSE(outcome.scene.materials.empty());
  EXPECT_FALSE(outcome.scene.materials[0].base_color_texture.used());
  EXPECT_TRUE(outcome.tells(told)) << outcome.all();
  EXPECT_TRUE(outcome.tells("images[0]: ")) << outcome.all();
}

TEST(ImageFault, SoundOneLoads) {
  const LoadOutcome outcome = with_image(make_png({10, 20, 30, 40}));
  ASSERT_EQ(outcome.scene.images.size(), 1u) << outcome.all();
  EXPECT_EQ(outcome.scene.images[0].bytes, (std::vector<uint8_t>{10, 20, 30, 40}));
  EXPECT_TRUE(outcome.scene.textures.at(0).srgb);
  EXPECT_TRUE(outcome.warnings.empty()) << outcome.all();
}

TEST(ImageFault, HeaderThatClaimsTooMuchNamesTheLimit) {
  expect_placeholder(with_image(make_png({1, 2, 3, 4}, 60000)),
                     "LIMIT: 60000 x 60000 pixels, the limit is 268435456 (--limit-image-pixels)");
}

TEST(ImageFault, HeaderThatClaimsMoreThanIsThere) {
  expect_placeholder(with_image(make_png({1, 2, 3, 4}, 4096)), "IMAGE_DATA_INVALID");
  expect_placeholder(with_image(make_png({1, 2, 3, 4}, 0)), "IMAGE_DATA_INVALID");
}

TEST(ImageFault, EveryTruncationIsAPlaceholder) {
  const auto whole = make_png({1, 2, 3, 4});
  const size_t data_end = whole.size() - 12 - 4;  // before IEND and the data's check sum
  for (size_t size = 1; size < data_end; size += 3) {
    expect_placeholder(with_image({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)}), "IMAGE_");
  }
}

TEST(ImageFault, OtherContents) {
  expect_placeholder(with_image({'G', 'I', 'F', '8', '9', 'a', 0, 0}), "IMAGE_UNRECOGNIZED_FORMAT");
  expect_placeholder(with_image({0xff, 0xd8, 0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F'}), "IMAGE_DATA_INVALID");
  expect_placeholder(with_image({'R', 'I', 'F', 'F', 4, 0, 0, 0, 'W', 'E', 'B', 'P', 'V', 'P', '8', ' '}),
                     "IMAGE_");
}

TEST(ImageFault, StrictMakesItAnError) {
  expect_refused(with_image(make_png({1, 2, 3, 4}, 60000), true), "images[0]: LIMIT");
}

TEST(ImageFault, SumOfPixelsIsBounded) {
  LoadOptions options;
  options.limits.total_pixels = 0;
  expect_refused(with_image(make_png({1, 2, 3, 4}), false, options), "--limit-total-pixels");
}

TEST(ImageFault, MissingFileIsAPlaceholderButLeavingTheFolderIsRefused) {
  GltfFixture gltf = textured_triangle();
  gltf.json["images"] = {{{"uri", "none.png"}}};
  expect_placeholder(load_outcome(gltf), "none.png");
  expect_refused(load_outcome(gltf, {}, true), "none.png");
  gltf.json["images"] = {{{"uri", "../none.png"}}};
  expect_refused(load_outcome(gltf), "leaves the asset's folder");
  gltf.json["images"] = {{{"uri", "http://localhost/none.png"}}};
  expect_refused(load_outcome(gltf), "INVALID_URI");
  gltf.json["images"] = json::array({json::object()});
  expect_placeholder(load_outcome(gltf), "ONE_OF_MISMATCH");
}

TEST(ImageFault, TextureWithoutAnImage) {
  GltfFixture gltf = textured_triangle();
  gltf.json["textures"] = json::array({json::object()});
  const LoadOutcome outcome = load_outcome(gltf);
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  EXPECT_TRUE(outcome.tells("textures[0]: has no image that can be read"));
}

}  // namespace

}  // namespace halflight
