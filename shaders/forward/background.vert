// Full-screen triangle at the far plane.
#version 460
layout(location = 0) out vec2 out_ndc;

void main() {
  out_ndc = vec2(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1);
  gl_Position = vec4(out_ndc, 0, 1);
}
