// Pieces of a report: a page that opens from disk, its plots, tables and pictures. Nothing is loaded from a
// network.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/plots.h"
#include "report/race.h"

namespace halflight {

/// Text for HTML; bytes that are no UTF-8 become question marks.
std::string html_text(std::string_view);
/// A relative path as a URL.
std::string html_path(std::string_view);

/// A whole page: `body` is HTML, style and script come along.
std::string html_page(std::string_view title, const std::string& body);

/// A heading with an anchor, and what stands below it.
std::string html_section(std::string_view id, std::string_view title, const std::string& body);

/// Rows of name and value.
std::string html_facts(const Facts&);

/// The plot in two sizes, one for wide and one for narrow pages, or the reason why there is none.
std::string html_plot(const Plot&, const std::string& name, std::string_view caption);

/// A cell that starts a row, then the rest; on narrow pages each cell shows its column's heading beside it.
/// Cells are HTML.
std::string html_table(const std::vector<std::string>& headings,
                       const std::vector<std::vector<std::string>>& rows);

/// A picture beside others, and its error map where it has one. Paths are relative to the page.
struct PanelPicture {
  std::string label, caption;
  std::string png, error_png;
};

/// Pictures side by side, moved and enlarged together, with a wipe between any two; error maps at a switch.
/// `scale` is what the ends of the map's colours stand for.
std::string html_pictures(const std::vector<PanelPicture>&, int width, int height, double scale);

}  // namespace halflight
