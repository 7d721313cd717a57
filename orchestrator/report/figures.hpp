#pragma once

#include <string>

#include "report/analysis.hpp"

namespace sandglass::report {

/// What the report needs beside the run directory.
struct ReportTools {
  std::string templates_root;               ///< the templates/ folder
  std::string python = "/usr/bin/python3";  ///< a Python that has matplotlib
  double deadline = 120;                    ///< seconds that drawing may take
};

/// Draws every figure of the analysis: RUN_DIRECTORY/figures/NAME.svg and NAME.png, by
/// templates/report/draw.py. Nothing is started when there is no figure. Throws Error::participant
/// when drawing fails, and what run_to_end throws.
void draw_figures(const Analysis& analysis, const std::string& run_directory,
                  const ReportTools& tools);

/// What draw.py is given, as JSON: curves in the units they are drawn in.
std::string figures_to_json(const Analysis& analysis);

/// The picture without what looks the same at any size: at most about `most` points, of every
/// stretch of the curve the lowest and the highest. Both vectors are as long as each other.
void thin(std::vector<double>& x, std::vector<double>& y, size_t most);

}  // namespace sandglass::report
