out vec3 v_direction;

// One triangle over the whole screen, at depth 0: infinity.
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_direction = (camera_from_clip * vec4(corner, 0.0, 1.0)).xyz;
  gl_Position = vec4(corner, 0.0, 1.0);
}
