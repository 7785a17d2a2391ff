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

/// The stage of a technique that runs on the GPU, and the light it leaves out.
void add_gpu_stage(const TechniqueInfo& technique, Plan& plan) {
  std::vector<std::string> left_out{"shadows"};
  if (plan.kinds.surfaces) left_out.push_back("light from surface to surface");
  if (plan.kinds.emitters) left_out.push_back("light of emissive surfaces");
  if (plan.kinds.punctual) left_out.push_back("punctual lights");
  const bool runs = plan.kinds.environment;
  plan.stages.push_back(
      {"environment on the GPU", runs,
       !runs ? fmt::format("nothing for {} to do: it knows light of an environment only", technique.id)
             : fmt::format("{} leaves out {}", technique.id, fmt::join(left_out, ", "))});
}

}  // namespace

SceneNeeds scene_needs(const Scene& scene) {
  SceneNeeds needs;
  std::vector<bool> used(scene.materials.size(), false);
  for (uint32_t material : scene.triangle_material) used[material] = true;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = scene.materials[i];
    needs.surfaces |= !material.unlit && material.model != BrdfModel::none;
    needs.emitters |= !material.unlit && material.emissive();
    needs.specular |= has_specular_lobe(material);
    needs.alpha |= material.alpha_mode != AlphaMode::opaque;
  }
  needs.environment = has_light(scene.environment);
  needs.punctual =
      static_cast<size_t>(std::count_if(scene.lights.begin(), scene.lights.end(), [](const auto& light) {
        return max_component(light.intensity) > 0;
      }));
  return needs;
}

Plan make_plan(const SceneNeeds& needs, const TechniqueInfo& technique, Target target,
               LightSelection selection, const std::string& raster, const std::string& why_backend) {
  const bool direct = selection != LightSelection::indirect;
  const bool indirect = selection != LightSelection::direct;
  const bool continuous = target == Target::continuous;
  const bool handful = needs.punctual > 0 && needs.punctual <= handful_of_lights;
  const std::string unasked = direct ? "only direct light is asked for" : "only indirect light is asked for";

  Plan plan;
  plan.show_emission = direct;
  plan.antialiased = continuous && !technique.exact;
  plan.gbuffer = !technique.traces_from_camera;
  plan.direct_punctual = handful && direct && needs.surfaces && plan.gbuffer;
  // A shadow map's edge is not a ray's: what converges to the integral is lit by rays.
  plan.shadow_maps = handful && !continuous && !raster.empty() && needs.surfaces;
  plan.kinds.environment = needs.environment && direct && needs.surfaces;
  plan.kinds.emitters = needs.emitters && direct && needs.surfaces;
  plan.kinds.punctual = needs.punctual > 0 && direct && needs.surfaces && !plan.direct_punctual;
  plan.kinds.surfaces = needs.surfaces && needs.lit() && indirect;

  const auto stage = [&](std::string name, bool runs, std::string why) {
    plan.stages.push_back({std::move(name), runs, std::move(why)});
  };
  const std::string own_rays = fmt::format("{} sends rays of its own from the camera", technique.id);
  stage("g-buffer", plan.gbuffer,
        !plan.gbuffer    ? own_rays
        : raster.empty() ? "by rays: " + why_backend
                         : raster + ": " + why_backend);
  stage("antialiasing", plan.antialiased,
        !plan.gbuffer      ? "each ray of the camera has its own place in the pixel"
        : plan.antialiased ? "the continuous target moves the pixel grid each round"
        : continuous       ? "a single pass sees pixel centres only"
                           : "the discrete target sees pixel centres only");
  stage("alpha filter", needs.alpha,
        needs.alpha ? "masked or blended materials" : "every material is opaque");

  const std::string count =
      fmt::format("{} punctual light{}", needs.punctual, needs.punctual == 1 ? "" : "s");
  stage("shadow maps", plan.shadow_maps,
        needs.punctual == 0 ? "no punctual lights"
        : plan.shadow_maps  ? count
        : continuous        ? "the continuous target lights points by rays"
        : !handful          ? count + ": more than " + std::to_string(handful_of_lights) + " are members of S"
                            : "rays do their work without OpenGL");
  stage("direct punctual light", plan.direct_punctual,
        needs.punctual == 0    ? "no punctual lights"
        : !direct              ? unasked
        : !plan.gbuffer        ? own_rays
        : plan.direct_punctual ? count + (plan.shadow_maps ? " by shadow maps" : ", a ray each")
                               : "punctual lights are members of S");

  const bool light_set = uses_light_set(technique, target);
  const std::string without_set =
      technique.has_own_lights
          ? fmt::format("{} makes strata, tree and cut of its own", technique.id)
          : fmt::format(
                "{} {}needs no S", technique.id,
                technique.target == TargetSupport::both ? "follows rays in the continuous target and " : "");
  const auto kind = [&](const char* name, bool runs, bool present, const char* what, bool asked) {
    stage(name, runs && light_set,
          !present             ? std::string("the scene has no ") + what
          : !needs.surfaces    ? "nothing here reflects light"
          : !asked             ? unasked
          : runs && !light_set ? without_set
          : runs               ? std::string("for the scene's ") + what
                               : "found outside S");
  };
  kind("environment points", plan.kinds.environment, needs.environment, "environment", direct);
  kind("emitter points", plan.kinds.emitters, needs.emitters, "emissive surfaces", direct);
  kind("punctual points", plan.kinds.punctual, needs.punctual > 0, "punctual lights", direct);
  kind("surface points", plan.kinds.surfaces, needs.lit() && needs.surfaces, "lit surfaces", indirect);

  plan.light_set = light_set && plan.kinds.any();
  stage("light tree and cut", plan.light_set,
        !plan.kinds.any() ? "S is empty"
        : light_set       ? "S has members"
                          : without_set);
  if (technique.device == Device::gpu) add_gpu_stage(technique, plan);
  const bool counts = technique.counts_brdf_rays && plan.light_set && needs.specular;
  stage("brdf rays", counts,
        !plan.kinds.any()             ? "S is empty"
        : !light_set                  ? without_set
        : !needs.specular             ? "no material has a specular lobe"
        : !technique.counts_brdf_rays ? fmt::format("{} does not count BRDF rays", technique.id)
                                      : "specular lobes are counted over the cut");
  return plan;
}

}  // namespace halflight
