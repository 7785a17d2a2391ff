#include "scene/gltf_animation.h"

#include <algorithm>
#include <set>

namespace halflight {

namespace {

std::vector<double> key_value(const GltfKeys& keys, size_t key) {
  const bool spline = keys.interpolation == GltfInterpolation::cubic_spline;
  const auto first = keys.values.begin() + static_cast<ptrdiff_t>(keys.width * (spline ? 3 * key + 1 : key));
  return {first, first + static_cast<ptrdiff_t>(keys.width)};
}

glm::dquat as_quaternion(const std::vector<double>& v) { return {v[3], v[0], v[1], v[2]}; }

std::vector<double> normalized_quaternion(std::vector<double> v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  if (!(length > 0)) return {0, 0, 0, 1};
  for (double& x : v) x /= length;
  return v;
}

/// Between keys k and k + 1; `t` in [0, 1] and `duration` in seconds.
std::vector<double> between_keys(const GltfKeys& keys, size_t k, double t, double duration) {
  std::vector<double> a = key_value(keys, k), b = key_value(keys, k + 1);
  switch (keys.interpolation) {
    case GltfInterpolation::step:
      return a;
    case GltfInterpolation::linear:
      if (keys.rotation) {
        const glm::dquat q =
            glm::slerp(as_quaternion(normalized_quaternion(a)), as_quaternion(normalized_quaternion(b)), t);
        return normalized_quaternion({q.x, q.y, q.z, q.w});
      }
      for (size_t i = 0; i < a.size(); ++i) a[i] += t * (b[i] - a[i]);
      return a;
    case GltfInterpolation::cubic_spline:
      break;
  }
  const double t2 = t * t, t3 = t2 * t;
  const float* out_tangent = keys.values.data() + keys.width * (3 * k + 2);
  const float* in_tangent = keys.values.data() + keys.width * (3 * (k + 1));
  for (size_t i = 0; i < a.size(); ++i) {
    a[i] = (2 * t3 - 3 * t2 + 1) * a[i] + duration * (t3 - 2 * t2 + t) * out_tangent[i] +
           (-2 * t3 + 3 * t2) * b[i] + duration * (t3 - t2) * in_tangent[i];
  }
  return keys.rotation ? normalized_quaternion(a) : a;
}

bool is_increasing(const std::vector<float>& times) {
  for (size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) return false;
  }
  return !times.empty();
}

void apply_channel(GltfNode& node, std::vector<double>& weights, GltfPath path,
                   const std::vector<double>& value) {
  switch (path) {
    case GltfPath::translation:
      node.translation = {value[0], value[1], value[2]};
      break;
    case GltfPath::scale:
      node.scale = {value[0], value[1], value[2]};
      break;
    case GltfPath::rotation:
      node.rotation = as_quaternion(value);
      break;
    case GltfPath::weights:
      weights = value;
      return;
    case GltfPath::other:
      return;
  }
  node.matrix.reset();
}

void animate(GltfSource& source, const GltfDocument& document, GltfReader& reader, double seconds,
             std::vector<GltfNode>& nodes, GltfPose& pose) {
  std::set<std::pair<int32_t, GltfPath>> moved;
  for (size_t a = 0; a < document.animations.size(); ++a) {
    const GltfAnimation& animation = document.animations[a];
    for (size_t c = 0; c < animation.channels.size(); ++c) {
      const GltfChannel& channel = animation.channels[c];
      if (channel.node < 0 || channel.path == GltfPath::other) continue;
      if (!moved.insert({channel.node, channel.path}).second) continue;
      const GltfAnimationSampler& sampler = animation.samplers[channel.sampler];
      const std::string place = fmt::format("animations[{}].channels[{}]", a, c);
      if (!reader.has_data(sampler.input) || !reader.has_data(sampler.output)) {
        source.warn(place, "UNDEFINED_PROPERTY", "its buffer has no data; the channel is ignored");
        continue;
      }
      GltfKeys keys;
      keys.times = reader.floats(sampler.input);
      keys.values = reader.floats(sampler.output);
      keys.interpolation = sampler.interpolation;
      keys.rotation = channel.path == GltfPath::rotation;
      const size_t values_a_key = keys.values.size() / keys.times.size();
      keys.width = keys.interpolation == GltfInterpolation::cubic_spline ? values_a_key / 3 : values_a_key;
      if (!is_increasing(keys.times)) {
        source.warn(fmt::format("animations[{}].channels[{}]", a, c),
                    "ACCESSOR_ANIMATION_INPUT_NON_INCREASING",
                    "times do not increase; the channel is ignored");
        continue;
      }
      apply_channel(nodes[channel.node], pose.weights[channel.node], channel.path, evaluate(keys, seconds));
    }
  }
}

glm::dmat4 local_matrix(const GltfNode& node) {
  if (node.matrix) {
    glm::dmat4 m;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) m[column][row] = (*node.matrix)[4 * column + row];
    }
    return m;
  }
  const double length = glm::length(node.rotation);
  const glm::dquat rotation = length > 0 ? node.rotation / length : glm::dquat(1, 0, 0, 0);
  glm::dmat4 m = glm::mat4_cast(rotation);
  for (int axis = 0; axis < 3; ++axis) m[axis] *= node.scale[axis];
  m[3] = glm::dvec4(node.translation, 1);
  return m;
}

}  // namespace

std::vector<double> evaluate(const GltfKeys& keys, double seconds) {
  const size_t last = keys.times.size() - 1;
  const auto finish = [&](std::vector<double> v) {
    return keys.rotation ? normalized_quaternion(std::move(v)) : v;
  };
  if (!(seconds > keys.times.front())) return finish(key_value(keys, 0));
  if (seconds >= keys.times[last]) return finish(key_value(keys, last));
  const auto after = std::upper_bound(keys.times.begin(), keys.times.end(), seconds);
  const size_t k = static_cast<size_t>(after - keys.times.begin()) - 1;
  const double begin = keys.times[k], duration = keys.times[k + 1] - begin;
  return finish(between_keys(keys, k, (seconds - begin) / duration, duration));
}

GltfPose pose_nodes(GltfSource& source, const GltfDocument& document, GltfReader& reader, double seconds) {
  GltfPose pose;
  std::vector<GltfNode> nodes = document.nodes;
  pose.weights.resize(nodes.size());
  std::vector<bool> is_child(nodes.size(), false);
  for (size_t i = 0; i < nodes.size(); ++i) {
    const GltfNode& node = nodes[i];
    pose.weights[i] =
        !node.weights.empty() || node.mesh < 0 ? node.weights : document.meshes[node.mesh].weights;
    for (const uint32_t child : node.children) is_child[child] = true;
  }
  animate(source, document, reader, seconds, nodes, pose);

  // Joints may lie outside the shown scene, so every tree is walked.
  pose.world.resize(nodes.size());
  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    if (!is_child[i]) pose.world[i] = local_matrix(nodes[i]), order.push_back(i);
  }
  for (size_t next = 0; next < order.size(); ++next) {
    const uint32_t parent = order[next];
    for (const uint32_t child : nodes[parent].children) {
      pose.world[child] = pose.world[parent] * local_matrix(nodes[child]);
      order.push_back(child);
    }
  }

  std::vector<bool> taken(nodes.size(), false);
  for (const uint32_t root : document.roots) {
    if (!taken[root]) pose.shown.push_back(root), taken[root] = true;
  }
  for (size_t next = 0; next < pose.shown.size(); ++next) {
    const auto& children = nodes[pose.shown[next]].children;
    pose.shown.insert(pose.shown.end(), children.begin(), children.end());
  }
  return pose;
}

}  // namespace halflight
