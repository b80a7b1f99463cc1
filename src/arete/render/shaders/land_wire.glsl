// Gives each corner its barycentric coordinates; the fragment stage draws edges
// where one is near 0.
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

in vec2 v_posts[];
in vec3 v_from_eye[];
in float v_height[];

out vec2 posts;
out vec3 from_eye;
out float height;
out vec3 corner;

void main() {
  for (int i = 0; i < 3; ++i) {
    gl_Position = gl_in[i].gl_Position;
    posts = v_posts[i];
    from_eye = v_from_eye[i];
    height = v_height[i];
    corner = vec3(i == 0, i == 1, i == 2);
    EmitVertex();
  }
  EndPrimitive();
}
