in vec2 v_posts;

uniform vec3 key_colour;
out vec4 colour;

void main() {
#ifdef MASK
  if (!is_valid(footprint(1, v_posts, dFdx(v_posts), dFdy(v_posts)))) discard;
#endif
  colour = vec4(key_colour, 1.0);
}
