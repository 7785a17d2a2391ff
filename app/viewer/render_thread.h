// The renderer on a thread of its own: the window posts wishes and reads snapshots, and never waits.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/stopwatch.h"
#include "film/image_writers.h"
#include "session.h"

namespace halflight {

/// Loads a scene; runs on the render thread and may throw Error. May change how it is displayed at first.
using SceneLoader = std::function<Scene(Messages&, DisplaySettings&)>;

/// What stays the same while one scene is open.
struct SceneSummary {
  std::string name;
  std::vector<Camera> cameras;
  std::vector<std::string> material_names;
  LightEdits lights;  ///< as the file has them
  std::string environment_name;
  std::optional<GlDescription> gl;
  size_t triangles = 0;
  DisplaySettings display;  ///< to begin with
};

/// The picture so far and what is known about it.
struct Snapshot {
  uint64_t scene_number = 0;  ///< grows with every scene opened
  std::shared_ptr<const SceneSummary> opened;
  ImageRgb picture;
  Camera camera;  ///< that it was taken with
  LightEdits lights;
  SessionStats stats;
  Plan plan;
  std::string technique;
  Target target = Target::discrete;
  double mean_samples = 0, estimated_relmse = -1;
  double seconds = 0;                     ///< since the picture was begun again
  int drawn_width = 0, drawn_height = 0;  ///< of a draft before it was enlarged to the picture's size
  uint64_t nan_samples = 0;
  Vec3 pivot{0};           ///< what the camera looks at
  bool converged = false;  ///< the sample limit is reached, or the technique has no more to give
};

/// How large drafts are to be, as a share of the picture's width, from `before` on: one took `seconds` that
/// hang on its size and was `drawn` times as wide as the picture. In steps of an eighth from 1 down to a
/// quarter, the largest that is there in time.
float next_draft_scale(double seconds, float drawn, float before);

class RenderThread {
 public:
  RenderThread(SceneLoader, const RenderSettings&, const DisplaySettings&, uint32_t sample_limit);
  ~RenderThread();

  // Wishes; the latest of each kind wins, and the pass in flight is dropped. While camera or lights move on
  // and on, the first picture of each state that is begun is finished and shown: there is one to see at any
  // time.
  void open(SceneLoader);
  void open_environment(const std::string& path, const LoadLimits&);
  void set_camera(const Camera&);
  void set_settings(const RenderSettings&);
  void edit_lights(const LightEdits&);
  void set_paused(bool);

  /// The newest snapshot; null before the first picture.
  std::shared_ptr<const Snapshot> latest() const;
  /// Loading a scene, as opposed to converging.
  bool busy_loading() const;
  /// Rethrows what kept the very first scene from opening: there is nothing to show then.
  void rethrow_if_nothing_opened() const;
  /// The next message nobody has seen: a failure to open something, or a warning.
  struct Notice {
    std::string text;
    bool error;
  };
  std::optional<Notice> next_notice();

 private:
  struct Wishes {
    std::optional<SceneLoader> open;
    std::optional<Camera> camera;
    std::optional<RenderSettings> settings;
    std::optional<LightEdits> lights;
    bool any() const { return open || camera || settings || lights; }
    bool moves() const { return any() && !open && !settings; }
  };

  void wish(const std::function<void(Wishes&)>& change);
  bool drops_pass() const;
  void loop();
  void apply(Wishes);
  void open_scene(const SceneLoader&);
  void run_one_pass();
  void begin_picture();
  uint32_t next_round_samples() const;
  bool draft_is_done() const;
  void learn_draft_scale();
  float drawn_scale() const;
  void publish();
  bool converged() const;
  void report(const std::string& text, bool error);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Wishes wishes_;
  std::stop_source pass_stop_;
  std::shared_ptr<const Snapshot> latest_;
  std::deque<Notice> notices_;
  std::exception_ptr nothing_opened_;
  bool paused_ = false, quit_ = false, loading_ = true;
  bool shown_ = true;  ///< the state that was last begun has a picture

  // The render thread's own.
  RenderSettings settings_;
  DisplaySettings display_;
  uint32_t sample_limit_;
  Messages messages_;
  std::unique_ptr<Session> session_;
  std::shared_ptr<const SceneSummary> opened_;
  uint64_t scene_number_ = 0;
  uint32_t subset_ = 0, rounds_ = 0;
  bool has_pass_ = false;       ///< the picture begun has had its first
  bool done_ = false;           ///< and its last
  uint32_t round_samples_ = 0;  ///< a pixel, of the round in hand
  bool moving_ = false;         ///< camera or lights, as opposed to a scene or settings that were opened
  float draft_scale_ = 1;       ///< of the next draft that a camera asks for
  Stopwatch since_restart_, since_shown_;

  std::thread thread_;
};

}  // namespace halflight
