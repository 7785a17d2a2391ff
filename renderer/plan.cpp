#include "plan.h"

#include <fmt/format.h>

#include <algorithm>

namespace halflight {

namespace {

bool has_light(const Environment& environment) {
  return environment.present() && environment.strength > 0 &&
         std::any_of(environment.map.pixels.begin(), environment.map.pixels.end(),
                     [](Vec3 radiance) { return max_component(radiance) > 0; });
}

bool has_specular_lobe(const Material& material) {
  if (material.unlit || material.model == BrdfModel::none) return false;
  if (material.model != BrdfModel::ggx) return max_component(material.phong_specular) > 0;
  return material.metallic > 0 || (material.specular > 0 && material.ior != 1);
}

std::string counted(size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// Decides stage by stage; what is decided first is known to those that follow.
class Planner {
 public:
  Planner(const SceneNeeds&, const PlanRequest&);
  Plan make();

 private:
  void plan_gbuffer();
  void plan_punctual();
  void plan_points();
  void plan_tree_and_cut();
  void plan_brdf_rays();
  void plan_learning();
  void plan_gpu();

  void stage(Stage, bool runs, std::string why);
  void points(Stage, bool runs, bool present, const char* what, bool asked);
  bool runs(Stage s) const { return plan_.runs.has(s); }
  bool forced(Stage s) const { return asked_.forced.has(s); }
  bool continuous() const { return asked_.target == Target::continuous; }
  bool sees_gbuffer() const { return !technique_.traces_from_camera; }
  bool has(Stage s) const { return has_now_.has(s); }
  bool may_have(Stage s) const { return has_now_.has(s) || has_by_default_.has(s); }
  std::string settings_say() const { return fmt::format("{} does without, as it is set", technique_.id); }
  bool few_lights() const;

  const SceneNeeds& needs_;
  const PlanRequest& asked_;
  const TechniqueInfo& technique_;
  bool direct_, indirect_;
  bool handful_;    ///< of punctual lights, which are then found outside S
  bool makes_set_;  ///< S by the frame, or strata by the technique
  std::string unasked_, own_rays_, without_set_;
  StageSet has_now_, has_by_default_;  ///< the technique's own stages
  Plan plan_;
};

Planner::Planner(const SceneNeeds& needs, const PlanRequest& asked)
    : needs_(needs),
      asked_(asked),
      technique_(asked.technique),
      direct_(asked.light != LightSelection::indirect),
      indirect_(asked.light != LightSelection::direct),
      handful_(needs.punctual > 0 && needs.punctual <= handful_of_lights),
      makes_set_(technique_.has_own_lights || uses_light_set(technique_, asked.target)),
      unasked_(direct_ ? "only direct light is asked for" : "only indirect light is asked for"),
      own_rays_(fmt::format("{} sends rays of its own from the camera", technique_.id)),
      without_set_(fmt::format(
          "{} {}needs no S", technique_.id,
          technique_.target == TargetSupport::both ? "follows rays in the continuous target and " : "")) {}

void Planner::stage(Stage s, bool runs, std::string why) {
  if (!runs && forced(s)) runs = true, why = "forced, though: " + why;
  plan_.stages.push_back({s, runs, std::move(why)});
  plan_.runs.add(s, runs);
}

void Planner::plan_gbuffer() {
  plan_.redraws = continuous() && !technique_.exact;
  plan_.antialiased = plan_.redraws && !(asked_.pixel_centres && sees_gbuffer());
  plan_.show_emission = direct_;
  stage(Stage::animation, needs_.animations > 0,
        needs_.animations > 0 ? fmt::format("{} posed at {:g} s, once",
                                            counted(needs_.animations, "animation"), needs_.at_seconds)
                              : "nothing moves");
  stage(Stage::gbuffer, sees_gbuffer(),
        !sees_gbuffer()         ? own_rays_
        : asked_.raster.empty() ? "by rays: " + asked_.why_backend
                                : asked_.raster + ": " + asked_.why_backend);
  stage(Stage::antialiasing, plan_.antialiased,
        !sees_gbuffer()     ? "each ray of the camera has its own place in the pixel"
        : plan_.antialiased ? "the continuous target moves the pixel grid each round"
        : plan_.redraws     ? "pixel centres are asked for"
        : continuous()      ? "a single pass sees pixel centres only"
                            : "the discrete target sees pixel centres only");
  stage(Stage::alpha_filter, needs_.alpha,
        needs_.alpha ? "masked or blended materials" : "every material is opaque");
  plan_.gbuffer = runs(Stage::gbuffer);
}

void Planner::plan_punctual() {
  // A shadow map's edge is not a ray's: what converges to the integral is lit by rays.
  const bool by_maps = !continuous() && !asked_.raster.empty() && needs_.surfaces;
  const bool at_pixels = handful_ && direct_ && needs_.surfaces && sees_gbuffer();
  const bool at_points = handful_ && indirect_ && needs_.surfaces && makes_set_ && !continuous();
  const std::string count = counted(needs_.punctual, "punctual light");
  stage(Stage::shadow_maps, by_maps && (at_pixels || at_points),
        needs_.punctual == 0     ? "no punctual lights"
        : !needs_.surfaces       ? "nothing here reflects light"
        : continuous()           ? "the continuous target lights points by rays"
        : !handful_              ? fmt::format("{}: more than {} are members of S", count, handful_of_lights)
        : asked_.raster.empty()  ? "rays do their work without OpenGL"
        : at_pixels || at_points ? count
                                 : "no stage asks for punctual light");
  plan_.shadow_maps = runs(Stage::shadow_maps);
  stage(Stage::direct_punctual, at_pixels,
        needs_.punctual == 0 ? "no punctual lights"
        : !needs_.surfaces   ? "nothing here reflects light"
        : !direct_           ? unasked_
        : !sees_gbuffer()    ? own_rays_
        : at_pixels          ? count + (plan_.shadow_maps ? " by shadow maps" : ", a ray each")
                             : "punctual lights are members of S");
  plan_.direct_punctual = runs(Stage::direct_punctual);
}

void Planner::points(Stage s, bool runs, bool present, const char* what, bool asked) {
  stage(s, runs && makes_set_,
        !present                    ? std::string("the scene has no ") + what
        : !needs_.surfaces          ? "nothing here reflects light"
        : !asked                    ? unasked_
        : runs && !makes_set_       ? without_set_
        : !runs                     ? "found outside S"
        : technique_.has_own_lights ? "drawn afresh in each stratum, for the scene's " + std::string(what)
                                    : "for the scene's " + std::string(what));
}

void Planner::plan_points() {
  LightKinds& kinds = plan_.kinds;
  kinds.environment = needs_.environment && direct_ && needs_.surfaces;
  kinds.emitters = needs_.emitters > 0 && direct_ && needs_.surfaces;
  kinds.punctual = needs_.punctual > 0 && direct_ && needs_.surfaces && !(handful_ && sees_gbuffer());
  kinds.surfaces = needs_.surfaces && needs_.lit() && indirect_;
  if (technique_.stages) {
    has_now_ = technique_.stages(asked_.settings, asked_.target, kinds);
    has_by_default_ = technique_.stages(SettingValues(), asked_.target, kinds);
  }
  if (may_have(Stage::strata))
    stage(Stage::strata, kinds.any(),
          kinds.any() ? "fixed by geometry, for each kind of light" : "no light to find");
  points(Stage::environment_points, kinds.environment, needs_.environment, "environment", direct_);
  points(Stage::emitter_points, kinds.emitters, needs_.emitters > 0, "emissive surfaces", direct_);
  points(Stage::punctual_points, kinds.punctual, needs_.punctual > 0, "punctual lights", direct_);
  points(Stage::surface_points, kinds.surfaces, needs_.lit() && needs_.surfaces, "lit surfaces", indirect_);
  if (may_have(Stage::pilot_set))
    stage(Stage::pilot_set, kinds.surfaces,
          kinds.surfaces ? "tells what surfaces send before the first round"
                         : "no surface is among the lights");
  plan_.set_kinds = {runs(Stage::environment_points), runs(Stage::emitter_points),
                     runs(Stage::surface_points), runs(Stage::punctual_points)};
}

/// So few that a cut of the least size holds every one of them: only punctual lights can be.
bool Planner::few_lights() const {
  const LightKinds& kinds = plan_.set_kinds;
  const double least = asked_.settings.get("cut.least"), count = asked_.settings.get("lights.count");
  if ((kinds.environment || kinds.surfaces || kinds.emitters) && 2 * count > least) return false;
  if (kinds.emitters && 2 * static_cast<double>(needs_.emitters) > least) return false;
  return !kinds.punctual || static_cast<double>(needs_.punctual) <= least;
}

void Planner::plan_tree_and_cut() {
  const LightKinds& kinds = plan_.set_kinds;
  const std::string set = technique_.has_own_lights ? "over the strata" : "S has members";
  stage(Stage::light_tree, makes_set_ && kinds.any(),
        !plan_.kinds.any() ? "S is empty"
        : makes_set_       ? set
                           : without_set_);
  const bool tree = runs(Stage::light_tree);
  plan_.light_set = tree && !technique_.has_own_lights;
  const bool few = few_lights();
  stage(Stage::cut, tree && has(Stage::cut) && !few,
        !plan_.kinds.any() ? "S is empty"
        : !makes_set_      ? without_set_
        : !has(Stage::cut) ? fmt::format("{} does not read it", technique_.id)
        : few              ? "few lights: the cut is the leaves"
                           : "clusters that draws are shared out among");
  plan_.cut = runs(Stage::cut)          ? CutMaking::refined
              : tree && has(Stage::cut) ? CutMaking::leaves
                                        : CutMaking::none;
  if (!may_have(Stage::near_clusters)) return;
  const bool local = kinds.near() || kinds.punctual;
  stage(Stage::near_clusters, tree && has(Stage::near_clusters) && local && !few,
        !has(Stage::near_clusters) ? settings_say()
        : !tree                    ? "S is empty"
        : !local                   ? "all light comes from afar"
        : few                      ? "the cut is the leaves"
                                   : "clusters near a block of pixels are split for it");
}

void Planner::plan_brdf_rays() {
  if (may_have(Stage::counted_brdf_rays))
    stage(Stage::counted_brdf_rays,
          has(Stage::counted_brdf_rays) && runs(Stage::light_tree) && needs_.specular,
          !plan_.kinds.any()               ? "S is empty"
          : !has(Stage::counted_brdf_rays) ? settings_say()
          : !needs_.specular               ? "no material has a specular lobe"
                                           : "specular lobes are counted over the cut");
  if (!may_have(Stage::traced_brdf_rays)) return;
  const bool near = plan_.kinds.near();
  stage(Stage::traced_brdf_rays,
        has(Stage::traced_brdf_rays) && (needs_.specular || near || !technique_.spares_brdf_rays),
        !has(Stage::traced_brdf_rays)  ? settings_say()
        : needs_.specular              ? "for specular lobes"
        : near                         ? "for light that may be near"
        : !technique_.spares_brdf_rays ? fmt::format("{} draws by the BRDF on every surface", technique_.id)
                                       : "no material has a specular lobe, and all light comes from afar");
}

void Planner::plan_learning() {
  if (!may_have(Stage::learned_visibility)) return;
  stage(Stage::learned_visibility, has(Stage::learned_visibility) && plan_.kinds.any(),
        !has(Stage::learned_visibility) ? settings_say()
        : !plan_.kinds.any()            ? "S is empty"
                                        : "later rounds know what earlier ones found hidden");
}

/// The stage of a technique that runs on the GPU, and the light it leaves out.
void Planner::plan_gpu() {
  if (technique_.device != Device::gpu) return;
  std::vector<std::string> left_out{"shadows"};
  if (plan_.kinds.surfaces) left_out.push_back("light from surface to surface");
  if (plan_.kinds.emitters) left_out.push_back("light of emissive surfaces");
  if (plan_.kinds.punctual) left_out.push_back("punctual lights");
  const bool lit = plan_.kinds.environment;
  stage(Stage::gpu_environment, lit,
        !lit ? fmt::format("nothing for {} to do: it knows light of an environment only", technique_.id)
             : fmt::format("{} leaves out {}", technique_.id, fmt::join(left_out, ", ")));
}

Plan Planner::make() {
  plan_gbuffer();
  plan_punctual();
  plan_points();
  plan_tree_and_cut();
  plan_brdf_rays();
  plan_learning();
  plan_gpu();
  return std::move(plan_);
}

}  // namespace

SceneNeeds scene_needs(const Scene& scene) {
  SceneNeeds needs;
  std::vector<size_t> triangles(scene.materials.size(), 0);
  for (uint32_t material : scene.triangle_material) ++triangles[material];
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (triangles[i] == 0) continue;
    const Material& material = scene.materials[i];
    needs.surfaces |= !material.unlit && material.model != BrdfModel::none;
    if (!material.unlit && material.emissive()) needs.emitters += triangles[i];
    needs.specular |= has_specular_lobe(material);
    needs.alpha |= material.alpha_mode != AlphaMode::opaque;
  }
  needs.environment = has_light(scene.environment);
  needs.punctual =
      static_cast<size_t>(std::count_if(scene.lights.begin(), scene.lights.end(), [](const auto& light) {
        return max_component(light.intensity) > 0;
      }));
  needs.animations = scene.facts.animations;
  needs.at_seconds = scene.facts.at_seconds;
  return needs;
}

Plan make_plan(const SceneNeeds& needs, const PlanRequest& asked) { return Planner(needs, asked).make(); }

}  // namespace halflight
