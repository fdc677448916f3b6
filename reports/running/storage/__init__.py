"""What is kept between builds: results, the keys they are kept under, and what those depend on."""
