#include "commands/compare_reference.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "core/random.h"
#include "core/stopwatch.h"
#include "film/image_writers.h"
#include "report/analysis.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

/// Two hashes of 64 bits side by side over everything that is put in.
class Digest {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
    bytes(&v, sizeof v);
  }
  void vec(Vec3 v) { value(v.x), value(v.y), value(v.z); }
  void bytes(const void* data, size_t size) {
    const char* at = static_cast<const char*>(data);
    for (size_t i = 0; i < size; i += 8) {
      uint64_t word = 0;
      std::memcpy(&word, at + i, std::min<size_t>(8, size - i));
      a_ = mix_bits(a_ ^ word) + 0x9e3779b97f4a7c15ull;
      b_ = hash_combine(b_, word);
    }
    a_ ^= size;
  }
  std::string text() const { return fmt::format("{:016x}{:016x}", mix_bits(a_), mix_bits(b_)); }

 private:
  uint64_t a_ = 1, b_ = 2;
};

void add_texel(Digest& digest, const GBufferTexel& texel) {
  digest.value(texel.triangle);
  for (const Vec3& v : {texel.position, texel.geometric_normal, texel.shading_normal, texel.tangent, texel.wo,
                        texel.emission, texel.throughput, texel.brdf.diffuse, texel.brdf.specular})
    digest.vec(v);
  digest.value(static_cast<uint32_t>(texel.brdf.model));
  digest.value(texel.brdf.f90);
  digest.value(texel.brdf.roughness.x), digest.value(texel.brdf.roughness.y);
}

/// What rays and lights are made of.
void add_scene(Digest& digest, const Scene& scene) {
  for (const Vertex& v : scene.vertices) {
    digest.vec(v.position);
    digest.value(v.uv[0].x), digest.value(v.uv[0].y), digest.value(v.uv[1].x), digest.value(v.uv[1].y);
    digest.value(v.color);
  }
  for (const UVec3& t : scene.triangles) digest.value(t.x), digest.value(t.y), digest.value(t.z);
  digest.bytes(scene.triangle_material.data(), scene.triangle_material.size() * sizeof(uint32_t));
  for (const Material& m : scene.materials)
    digest.value(static_cast<uint32_t>(m.alpha_mode)), digest.value(m.alpha_cutoff),
        digest.value(m.base_color.w);
  for (const ImageRgba8& image : scene.images) digest.bytes(image.bytes.data(), image.bytes.size());
  for (const ImageRgb& picture : scene.pictures)
    for (const Vec3& pixel : picture.pixels) digest.vec(pixel);
}

void add_frame(Digest& digest, const FrameView& frame) {
  digest.value(frame.gbuffer->width), digest.value(frame.gbuffer->height);
  for (const VirtualLight& light : frame.tree->lights) {
    digest.vec(light.position), digest.vec(light.normal), digest.vec(light.radiance);
    digest.value(light.measure), digest.value(static_cast<uint32_t>(light.kind)), digest.value(light.source);
  }
  for (const GBufferTexel& texel : frame.gbuffer->texels) add_texel(digest, texel);
  for (const Vec3& base : *frame.base) digest.vec(base);
}

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return fs::path(cache) / "halflight";
  const char* home = std::getenv("HOME");
  return home && *home ? fs::path(home) / ".cache" / "halflight" : fs::path();
}

/// Brute force in interleaved subsets, so that there is something to tell meanwhile.
ImageRgb brute_force(Session& session, const RenderSettings& settings, const ShareDone& done) {
  session.set_settings(settings);
  session.restart();
  constexpr uint32_t stride = 4, subsets = stride * stride;
  for (uint32_t offset = 0; offset < subsets; ++offset) {
    session.run_pass(1, stride, offset);
    if (done) done(static_cast<double>(offset + 1) / subsets);
  }
  return session.film().image();
}

/// Key of the reference in the cache.
std::string reference_key(Session& session, const RenderSettings& settings) {
  Digest digest;
  digest.bytes("discrete reference 1", 20);
  RenderSettings small = settings;
  small.width = std::min(settings.width, 16), small.height = std::min(settings.height, 12);
  for (const Vec3& pixel : brute_force(session, small, {}).pixels) digest.vec(pixel);
  session.set_settings(settings);
  add_scene(digest, session.scene());
  add_frame(digest, session.frame());
  return digest.text();
}

std::optional<ImageRgb> cached(const fs::path& file, const RenderSettings& settings, Messages& messages) {
  std::error_code ignored;
  if (file.empty() || !fs::exists(file, ignored)) return {};
  try {
    ImageRgb image = read_image(file, LoadLimits{});
    if (image.width == settings.width && image.height == settings.height) return image;
  } catch (const Error& error) {
    messages.warn(fmt::format("a cached reference is made again: {}", error.what()));
  }
  return {};
}

void keep(const fs::path& file, const ImageRgb& image, Messages& messages) {
  if (file.empty()) return;
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  try {
    if (failed)
      throw Error(ExitCode::failure, fmt::format("{}: {}", file.parent_path().string(), failed.message()));
    ImageMetadata metadata;
    metadata.text["software"] = "halflight " HALFLIGHT_VERSION;
    write_exr(file, image, metadata);
  } catch (const Error& error) {
    messages.warn(fmt::format("the reference is not cached: {}", error.what()));
  }
}

}  // namespace

ReferencePicture discrete_reference(Session& session, const RenderSettings& settings, Messages& messages,
                                    const ShareDone& done) {
  RenderSettings exact = settings;
  exact.technique = "reference";
  exact.target = Target::discrete;
  const fs::path folder = cache_folder();
  const fs::path file =
      folder.empty() ? fs::path() : folder / "references" / (reference_key(session, exact) + ".exr");
  ReferencePicture reference;
  reference.facts.exact = true;
  const Stopwatch watch;
  auto image = cached(file, exact, messages);
  const bool found = image.has_value();
  if (!found) {
    image = brute_force(session, exact, done);
    keep(file, *image, messages);
    reference.facts.seconds = watch.seconds();
  }
  reference.image = std::move(*image);
  session.set_settings(exact);
  const size_t lights = session.frame().tree->lights.size();
  reference.facts.how =
      fmt::format("brute force over all {} members of S, a ray to each from every pixel ({})", lights,
                  found ? "found in the cache" : fmt::format("{} s", number_text(reference.facts.seconds)));
  return reference;
}

ReferencePicture continuous_reference(Session& session, const RunRequest& race, double effort,
                                      const ShareDone& done) {
  RunRequest request = race;
  request.progressive = true;
  request.least_passes = 256;
  request.budgets = {effort * race.budgets.back()};
  request.settings.target = Target::continuous;
  // Draws of its own.
  request.settings.seed = hash_combine(race.settings.seed, 0x7265666572656e63ull);
  ReferencePicture reference;
  ReferencePicture nothing;
  nothing.image = ImageRgb(race.settings.width, race.settings.height);
  request.cost = measure_cost(session, request);
  const Stopwatch watch;
  double spp = 0;
  run_race(session, request, nothing, {}, done, [&](const Film& film) {
    reference.image = film.image();
    ImageRgb variance(film.width(), film.height());
    for (uint32_t i = 0; i < variance.pixels.size(); ++i) variance.pixels[i] = film.variance(i);
    reference.own = own_error(reference.image, variance);
    spp = film.mean_samples();
  });
  reference.facts.seconds = watch.seconds();
  reference.facts.relmse = reference.own.relmse;
  reference.facts.how =
      fmt::format("{}, {} samples a pixel in {} s ({:g} times the largest budget), with draws of its own",
                  request.settings.technique, number_text(spp), number_text(reference.facts.seconds), effort);
  if (race.settings.pixel_centres) reference.facts.how += ", through pixel centres";
  return reference;
}

DiscretisationError discretisation_error(const ReferencePicture& sum, const ReferencePicture& integral) {
  const ErrorMetrics metrics = measure_radiance_error(sum.image, integral.image);
  DiscretisationError error;
  error.relmse = metrics.relmse - integral.own.relmse;
  error.relmse_trimmed = metrics.relmse_trimmed - integral.own.relmse_trimmed;
  error.rmse = std::sqrt(std::max(0.0, metrics.rmse * metrics.rmse - integral.own.rmse * integral.own.rmse));
  error.smape = metrics.smape;
  error.own_relmse = integral.own.relmse;
  error.how = integral.facts.how;
  return error;
}

ReferencePicture given_reference(const std::string& file, const Options& options) {
  ReferencePicture reference;
  reference.image = read_image(file, options.load.limits);
  if (reference.image.width != options.render.width || reference.image.height != options.render.height)
    throw input_error(
        file, "",
        fmt::format("is {}x{}, and the race is {}x{}; --size gives it another size", reference.image.width,
                    reference.image.height, options.render.width, options.render.height));
  reference.facts.how = fmt::format("the file {}", file);
  return reference;
}

}  // namespace halflight
