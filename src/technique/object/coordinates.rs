//! Texture coordinate t of every vertex (thesis chapter 5, equation 5.1).
