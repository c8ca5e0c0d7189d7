#version 450 core
// Depth alone: what is drawn before the picture. Materials with a cutoff take mesh.frag.
void main() {}
