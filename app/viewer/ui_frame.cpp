#include "viewer/ui_frame.h"

#include <imgui.h>

#include <cstddef>

#include "viewer/panels.h"

namespace halflight {

static_assert(sizeof(UiVertex) == sizeof(ImDrawVert) && offsetof(UiVertex, uv) == offsetof(ImDrawVert, uv) &&
              offsetof(UiVertex, color) == offsetof(ImDrawVert, col));
static_assert(sizeof(ImDrawIdx) == sizeof(uint16_t));

UiContext::UiContext(UiPainter& painter, float scale) : painter_(painter), context_(ImGui::CreateContext()) {
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // nothing about the window is worth a file in the user's folder
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  set_panel_style(scale);
  unsigned char* pixels = nullptr;
  ImageRgba8 font;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &font.width, &font.height);
  font.bytes.assign(pixels, pixels + static_cast<size_t>(4) * font.width * font.height);
  io.Fonts->SetTexID(reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(painter_.set_texture(0, font))));
}

UiContext::~UiContext() { ImGui::DestroyContext(context_); }

void UiContext::draw(glm::ivec2 pixels, ImageRgba8* target) {
  const ImDrawData* data = ImGui::GetDrawData();
  std::vector<std::vector<UiCommand>> commands(data->CmdListsCount);
  std::vector<UiMesh> meshes;
  for (int i = 0; i < data->CmdListsCount; ++i) {
    const ImDrawList* list = data->CmdLists[i];
    for (const ImDrawCmd& command : list->CmdBuffer) {
      const auto texture = static_cast<uint32_t>(reinterpret_cast<uintptr_t>(command.GetTexID()));
      commands[i].push_back({{command.ClipRect.x, command.ClipRect.y},
                             {command.ClipRect.z, command.ClipRect.w},
                             texture,
                             command.IdxOffset,
                             command.ElemCount,
                             command.VtxOffset});
    }
    meshes.push_back(
        {{reinterpret_cast<const UiVertex*>(list->VtxBuffer.Data), static_cast<size_t>(list->VtxBuffer.Size)},
         {list->IdxBuffer.Data, static_cast<size_t>(list->IdxBuffer.Size)},
         commands[i]});
  }
  painter_.draw(meshes, {data->DisplaySize.x, data->DisplaySize.y}, pixels, target);
}

}  // namespace halflight
