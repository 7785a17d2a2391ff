// From a file to the first picture, against the least that any renderer with this ray tracer has to do: read
// the file and build the tree.
#include <fmt/format.h>
#include <tiny_gltf.h>

#include "benchmarks/benchmarks.h"
#include "benchmarks/generated_scenes.h"
#include "core/errors.h"
#include "core/parallel.h"
#include "film/image_writers.h"
#include "scene/load.h"
#include "session.h"
#include "support/temporary_folder.h"
#include "trace/embree_api.h"

namespace halflight {

namespace {

struct LeastSeconds {
  Seconds parse, build;
  Seconds total() const { return parse + build; }
};

const unsigned char* accessor_data(const tinygltf::Model& model, int accessor) {
  const tinygltf::Accessor& a = model.accessors[static_cast<size_t>(accessor)];
  const tinygltf::BufferView& view = model.bufferViews[static_cast<size_t>(a.bufferView)];
  return model.buffers[static_cast<size_t>(view.buffer)].data.data() + view.byteOffset + a.byteOffset;
}

/// Embree over tinygltf's own buffers, nothing copied, with the flags that the renderer sets.
void build_embree(const tinygltf::Model& model) {
  const RTCDevice device = rtcNewDevice(nullptr);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  for (const tinygltf::Mesh& mesh : model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const int positions = primitive.attributes.at("POSITION");
      const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                 accessor_data(model, positions), 0, 12,
                                 model.accessors[static_cast<size_t>(positions)].count);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 accessor_data(model, primitive.indices), 0, 12,
                                 model.accessors[static_cast<size_t>(primitive.indices)].count / 3);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
      rtcReleaseGeometry(geometry);
    }
  rtcCommitScene(scene);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw Error(ExitCode::failure, "Embree refuses the mesh");
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}

LeastSeconds least_seconds(const std::string& path) {
  LeastSeconds seconds;
  BothClocks watch;
  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string error, warning;
  if (!parser.LoadBinaryFromFile(&model, &error, &warning, path)) throw Error(ExitCode::failure, error);
  seconds.parse = watch.lap();
  build_embree(model);
  seconds.build = watch.lap();
  return seconds;
}

struct OpenSeconds {
  Seconds load, session, pass;
  Seconds total() const { return load + session + pass; }
};

/// As the window opens a scene: a light set that stands at once (or, with `whole_set`, the one asked for), a
/// first pass of 4 samples over every fourth pixel each way, then a picture of it, interpolated.
OpenSeconds open_seconds(const std::string& path, bool whole_set) {
  OpenSeconds seconds;
  BothClocks watch;
  Messages messages;
  RenderSettings settings;
  settings.backend = Backend::none;
  Scene scene = load_scene(path, {}, messages);
  seconds.load = watch.lap();
  Session session(std::move(scene), settings, messages);
  session.set_draft(!whole_set);
  seconds.session = watch.lap();
  session.run_subset(4, 0);
  const ImageRgb picture = session.preview();
  seconds.pass = watch.lap();
  if (picture.pixels.empty()) throw Error(ExitCode::failure, "no picture");
  return seconds;
}

double median_of(const std::vector<double>& values) { return quantile(values, 0.5); }

/// "12 (20)": medians of the milliseconds on the clock and of all threads.
template <class Run, class Read>
std::string median_text(const std::vector<Run>& runs, const Read& read) {
  std::vector<double> wall, cpu;
  for (const Run& run : runs) {
    const Seconds seconds = read(run);
    wall.push_back(1e3 * seconds.wall), cpu.push_back(1e3 * seconds.cpu);
  }
  return fmt::format("{:.0f} ({:.0f})", median_of(wall), median_of(cpu));
}

void compare_loading(const std::string& what, const Scene& scene, int rounds) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "scene.glb").string();
  {
    const GlbFile file = make_glb(scene, "scene");
    write_bytes_atomically(path, file.bytes);
    fmt::print("{}: {} triangles, {} vertices, {:.1f} MB\n", what, scene.triangles.size(),
               scene.vertices.size(), static_cast<double>(file.bytes.size()) * 1e-6);
  }
  std::vector<LeastSeconds> least;
  std::vector<OpenSeconds> open, whole;
  std::vector<double> wall, cpu;
  for (int round = 0; round < rounds; ++round) {
    least.push_back(least_seconds(path));
    open.push_back(open_seconds(path, false));
    whole.push_back(open_seconds(path, true));
    wall.push_back(open.back().total().wall / least.back().total().wall);
    cpu.push_back(open.back().total().cpu / least.back().total().cpu);
  }
  fmt::print("  tinygltf parses {} ms, Embree builds {} ms\n",
             median_text(least, [](const LeastSeconds& s) { return s.parse; }),
             median_text(least, [](const LeastSeconds& s) { return s.build; }));
  fmt::print("  halflight loads {} ms, opens the session {} ms, first picture {} ms\n",
             median_text(open, [](const OpenSeconds& s) { return s.load; }),
             median_text(open, [](const OpenSeconds& s) { return s.session; }),
             median_text(open, [](const OpenSeconds& s) { return s.pass; }));
  fmt::print("  with the whole light set at once the first picture takes {} ms\n",
             median_text(whole, [](const OpenSeconds& s) { return s.pass; }));
  std::sort(wall.begin(), wall.end());
  fmt::print(
      "  ratio of the wholes: {:.2f} on the clock ({:.2f} to {:.2f}; goal 2), {:.2f} in CPU time; medians of "
      "{} "
      "alternating rounds\n",
      median_of(wall), wall.front(), wall.back(), median_of(cpu), rounds);
  std::fflush(stdout);
}

}  // namespace

void benchmark_load(const BenchmarkOptions& options) {
  const size_t triangles = options.quick ? 100'000 : 1'000'000;
  const int rounds = options.quick ? 3 : 7;
  fmt::print("from a .glb to the first picture, {} threads; milliseconds on the clock (of all threads)\n",
             thread_count());
  compare_loading("room with lamp, camera and a knot", knot_room(triangles, Growth::mesh), rounds);
  compare_loading("a knot alone: camera and sky are added", bare_knot(triangles), rounds);
}

}  // namespace halflight
