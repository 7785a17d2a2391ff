// Wang & Åkerlund 2009, figure 3: where the samples of one pixel fall on the sphere. A plane of anisotropic
// Phong lies under an environment; the pixel is the one at its centre.
#include "commands/compare_report.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"
#include "film/image_writers.h"
#include "film/tonemap.h"
#include "scene/built_in_environments.h"
#include "scene/built_in_lit.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

Scene plane_under(const char* environment) {
  Scene scene;
  scene.facts.source = "plane of anisotropic Phong";
  Material brushed = phong_material("brushed", Vec3(0.15f), Vec3(0.6f), 1);
  brushed.model = BrdfModel::ashikhmin_shirley;
  brushed.exponents = {10, 400};
  place(scene, grid_mesh({9, 9}, [](float u, float v) { return Vec3(4 * (u - 0.5f), 0, 4 * (0.5f - v)); }),
        add_material(scene, brushed));
  scene.environment = make_built_in_environment(environment);
  add_camera(scene, "main", {0, 1.6f, 2.6f}, Vec3(0), 30);
  update_bounds(scene);
  return scene;
}

void set_mark(ImageRgba8& picture, int x, int y) {
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  uint8_t* texel = &picture.bytes[4 * (static_cast<size_t>(y) * picture.width + x)];
  texel[0] = 255, texel[1] = 40, texel[2] = 20, texel[3] = 255;
}

/// The environment as it looks, with a mark at each direction.
ImageRgba8 marked_map(const Environment& environment, const std::vector<Vec3>& directions) {
  ImageRgba8 picture = display_image(environment.map, -1, find_tone_map("filmic"));
  for (const Vec3 direction : directions) {
    const Vec2 uv = environment_uv(environment, direction);
    const int x = static_cast<int>(uv.x * static_cast<float>(picture.width)),
              y = static_cast<int>(uv.y * static_cast<float>(picture.height));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) set_mark(picture, x + dx, y + dy);
  }
  return picture;
}

}  // namespace

void run_wa_fig3(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  constexpr uint32_t draws = 512;
  constexpr const char* environment_name = "studio";
  Messages messages;
  RenderSettings settings = run.options.render;
  settings.width = settings.height = 65;
  settings.technique = default_discrete_technique, settings.target = Target::discrete;
  settings.light = LightSelection::direct;
  Session session(plane_under(environment_name), settings, messages);
  run.bench.interruption.keep_what_there_is();
  std::vector<std::vector<std::string>> rows;
  std::vector<std::pair<std::string, std::string>> pictures;
  for (const char* id : {"illumination", "brdf", "bidirectional"}) {
    settings.technique = id;
    session.set_settings(settings);
    const FrameView frame = session.frame();
    const auto technique = find_technique(id).make();
    technique->prepare(frame);
    PassRequest request;
    request.samples = draws;
    const auto inspection = technique->inspect(frame, request, 32 * 65 + 32);
    HALFLIGHT_CHECK(inspection.has_value());
    std::vector<Vec3> directions;
    for (const LightSample& draw : inspection->draws) {
      const VirtualLight& light = frame.tree->lights[draw.light];
      const Vec3 way = light.at_infinity()
                           ? light.position
                           : glm::normalize(light.position - frame.gbuffer->texels[32 * 65 + 32].position);
      directions.push_back(way);
      rows.push_back({id, fmt::format("{:.6f}", way.x), fmt::format("{:.6f}", way.y),
                      fmt::format("{:.6f}", way.z),
                      fmt::format("{:.6g}", inspection->probability[draw.light])});
    }
    write_png(run.folder / (std::string(id) + ".png"), marked_map(session.scene().environment, directions),
              {});
    pictures.emplace_back(std::string(id) + ".png", id);
  }
  machine = machine_facts(session);
  report.describe("scene",
                  "a plane of Ashikhmin–Shirley, exponents 10 and 400, under the environment 'studio'");
  report.describe("draws", draws);
  report.pictures("512 draws of the centre's pixel on the environment", pictures);
  report.data("fig3", {"technique", "x", "y", "z", "P"}, rows);
}

}  // namespace halflight
