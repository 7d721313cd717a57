#include "cli/cli.hpp"

int main(int argc, char** argv) { return sandglass::cli::main_program(argc, argv); }
