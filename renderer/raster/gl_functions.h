// The OpenGL entry points the rasteriser uses, one table a context: EGL, GLX and OSMesa each have their own
// addresses, and several contexts may live in one process.
#pragma once

#include <GL/glcorearb.h>

#include <functional>

namespace halflight {

// clang-format off
#define HALFLIGHT_GL_FUNCTIONS(X)                                                                             \
  X(ACTIVETEXTURE, ActiveTexture) X(ATTACHSHADER, AttachShader) X(BINDBUFFER, BindBuffer)                     \
  X(BINDBUFFERBASE, BindBufferBase) X(BINDBUFFERRANGE, BindBufferRange) X(BINDFRAMEBUFFER, BindFramebuffer)   \
  X(BINDTEXTURE, BindTexture) X(BINDVERTEXARRAY, BindVertexArray) X(BUFFERDATA, BufferData)                   \
  X(BUFFERSUBDATA, BufferSubData) X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus)                           \
  X(CLEARBUFFERFV, ClearBufferfv) X(CLEARBUFFERUIV, ClearBufferuiv) X(CLIPCONTROL, ClipControl)               \
  X(COLORMASK, ColorMask) X(COMPILESHADER, CompileShader) X(CREATEPROGRAM, CreateProgram)                     \
  X(CREATESHADER, CreateShader) X(DEBUGMESSAGECALLBACK, DebugMessageCallback)                                 \
  X(DELETEBUFFERS, DeleteBuffers) X(DELETEFRAMEBUFFERS, DeleteFramebuffers) X(DELETEPROGRAM, DeleteProgram)   \
  X(DELETESHADER, DeleteShader) X(DELETETEXTURES, DeleteTextures) X(DELETEVERTEXARRAYS, DeleteVertexArrays)   \
  X(DEPTHFUNC, DepthFunc) X(DEPTHMASK, DepthMask) X(DISABLE, Disable)                                         \
  X(DISPATCHCOMPUTE, DispatchCompute) X(DRAWBUFFER, DrawBuffer) X(DRAWBUFFERS, DrawBuffers)                   \
  X(DRAWELEMENTS, DrawElements) X(DRAWELEMENTSBASEVERTEX, DrawElementsBaseVertex)                             \
  X(ENABLE, Enable) X(SCISSOR, Scissor) X(BLENDFUNCSEPARATE, BlendFuncSeparate)                               \
  X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray)                                                         \
  X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D) X(FRAMEBUFFERTEXTURELAYER, FramebufferTextureLayer)           \
  X(GENBUFFERS, GenBuffers) X(GENFRAMEBUFFERS, GenFramebuffers) X(GENTEXTURES, GenTextures)                   \
  X(GENVERTEXARRAYS, GenVertexArrays) X(GETBOOLEANV, GetBooleanv) X(GETBUFFERSUBDATA, GetBufferSubData)       \
  X(GETERROR, GetError) X(GETFLOATV, GetFloatv) X(GETINTEGERV, GetIntegerv) X(GETINTEGER64V, GetInteger64v)   \
  X(GETPROGRAMINFOLOG, GetProgramInfoLog) X(GETPROGRAMIV, GetProgramiv)                                       \
  X(GETSHADERINFOLOG, GetShaderInfoLog) X(GETSHADERIV, GetShaderiv) X(GETSTRING, GetString)                   \
  X(GETUNIFORMLOCATION, GetUniformLocation) X(ISENABLED, IsEnabled) X(LINKPROGRAM, LinkProgram)               \
  X(MAPBUFFERRANGE, MapBufferRange) X(MEMORYBARRIER, MemoryBarrier) X(PIXELSTOREI, PixelStorei)               \
  X(POLYGONMODE, PolygonMode) X(READBUFFER, ReadBuffer) X(READPIXELS, ReadPixels)                             \
  X(SHADERSOURCE, ShaderSource) X(TEXIMAGE2D, TexImage2D) X(TEXIMAGE3D, TexImage3D)                           \
  X(TEXPARAMETERI, TexParameteri) X(UNIFORM1I, Uniform1i) X(UNIFORM1UI, Uniform1ui) X(UNIFORM1F, Uniform1f)   \
  X(UNIFORM2F, Uniform2f) X(UNIFORM3FV, Uniform3fv) X(UNIFORM4FV, Uniform4fv)                                 \
  X(UNIFORMMATRIX4FV, UniformMatrix4fv) X(UNMAPBUFFER, UnmapBuffer) X(USEPROGRAM, UseProgram)                 \
  X(VERTEXATTRIBIPOINTER, VertexAttribIPointer) X(VERTEXATTRIBPOINTER, VertexAttribPointer)                   \
  X(VIEWPORT, Viewport) X(GENERATEMIPMAP, GenerateMipmap) X(FINISH, Finish) X(GENQUERIES, GenQueries)         \
  X(DELETEQUERIES, DeleteQueries) X(BEGINQUERY, BeginQuery) X(ENDQUERY, EndQuery) X(GETQUERYIV, GetQueryiv)    \
  X(GETQUERYOBJECTUI64V, GetQueryObjectui64v)
// clang-format on

/// Finds a GL function by name; null where it is missing.
using ProcLoader = std::function<void*(const char*)>;

/// Function pointers named as in OpenGL without the prefix: `gl.DrawElements(...)` is glDrawElements.
struct GlFunctions {
#define HALFLIGHT_GL_MEMBER(TYPE, name) PFNGL##TYPE##PROC name = nullptr;
  HALFLIGHT_GL_FUNCTIONS(HALFLIGHT_GL_MEMBER)
#undef HALFLIGHT_GL_MEMBER

  /// Fills the table for the context that is current. Returns the name of the first missing function, or
  /// null.
  const char* load(const ProcLoader& find);
};

}  // namespace halflight
