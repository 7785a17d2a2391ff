#include "techniques/shared_distribution.h"

namespace halflight {

namespace {

/// Share of the specular lobe in what a point reflects.
float specular_share(const Brdf& brdf) {
  const float specular = luminance(brdf.specular), diffuse = luminance(brdf.diffuse);
  return specular > 0 ? specular / (specular + diffuse) : 0.0f;
}

}  // namespace

bool reflects(const GBufferTexel& texel) {
  return texel.hit() && !texel.brdf.black() && max_component(texel.throughput) > 0;
}

bool alike(const GBufferTexel& a, const GBufferTexel& b, float least_cosine) {
  constexpr float most_off_plane = 0.1f, most_ratio = 1.25f, most_apart = 0.1f;
  const Vec3 apart = b.position - a.position;
  const float off_plane = std::abs(glm::dot(apart, a.geometric_normal));
  const auto close = [](float x, float y) { return x <= most_ratio * y && y <= most_ratio * x; };
  return a.brdf.model == b.brdf.model && glm::dot(a.shading_normal, b.shading_normal) > least_cosine &&
         off_plane * off_plane <= square(most_off_plane) * glm::dot(apart, apart) &&
         close(a.brdf.roughness.x, b.brdf.roughness.x) && close(a.brdf.roughness.y, b.brdf.roughness.y) &&
         std::abs(specular_share(a.brdf) - specular_share(b.brdf)) < most_apart;
}

namespace {

/// Of one point or more, all alike to the first.
SharedPoint shared_point(std::span<const GBufferTexel* const> texels) {
  SharedPoint shared{*texels.front(), {}};
  if (texels.size() == 1) return shared;
  Aabb box;
  Vec3 normal(0), wo(0);
  for (const GBufferTexel* texel : texels) {
    box.extend(texel->position);
    normal += texel->shading_normal, wo += texel->wo;
  }
  GBufferTexel& middle = shared.texel;
  middle.position = box.centre(), shared.spread.extent = 0.5f * box.extent();
  middle.shading_normal = glm::normalize(normal), middle.wo = glm::normalize(wo);
  middle.tangent = glm::normalize(middle.tangent -
                                  glm::dot(middle.tangent, middle.shading_normal) * middle.shading_normal);
  float turned2 = 0;
  for (const GBufferTexel* texel : texels) {
    const float height = glm::dot(middle.shading_normal, texel->position - middle.position);
    shared.spread.height = std::max(shared.spread.height, std::abs(height));
    const Vec3 turned = texel->shading_normal - middle.shading_normal;
    turned2 = std::max(turned2, glm::dot(turned, turned));
  }
  shared.spread.normals = std::sqrt(turned2);
  return shared;
}

}  // namespace

SharedPoint DistributionLeaders::shared(uint32_t leader) const {
  std::array<const GBufferTexel*, most> texels{&gbuffer_->texels[leader]};
  size_t count = 0;
  for (uint32_t place = 0; place < most; ++place)
    if (leader_[place] == leader) texels[count++] = &gbuffer_->texels[pixel_at(place)];
  return shared_point(std::span(texels).first(std::max<size_t>(count, 1)));
}

}  // namespace halflight
