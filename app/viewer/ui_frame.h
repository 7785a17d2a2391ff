// Between ImGui and the painter: its context, font and draw lists.
#pragma once

#include "raster/ui_painter.h"

struct ImGuiContext;

namespace halflight {

/// ImGui's context with the program's style and its font on the GPU.
class UiContext {
 public:
  UiContext(UiPainter&, float scale);
  ~UiContext();
  UiContext(const UiContext&) = delete;
  UiContext& operator=(const UiContext&) = delete;

  /// Draws what ImGui::Render left, into the window or into `target`.
  void draw(glm::ivec2 pixels, ImageRgba8* target);

 private:
  UiPainter& painter_;
  ImGuiContext* context_;
};

}  // namespace halflight
