in vec2 v_posts;

uniform vec3 key_colour;
out vec4 colour;

void main() {
  vec2 posts_dx = dFdx(v_posts);
  vec2 posts_dy = dFdy(v_posts);
  if (has.y != 0 && !is_valid(footprint(1, v_posts, posts_dx, posts_dy))) discard;
  colour = vec4(key_colour, 1.0);
}
