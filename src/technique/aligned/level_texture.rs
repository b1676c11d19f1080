//! A paint's tileable textures by level of shade, and their file.
