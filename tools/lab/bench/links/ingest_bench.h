// Pose ingest benchmark: poses per second that a renderer receives, decodes, checks and binds to nodes.
#pragma once

namespace fire3dv::bench {

struct IngestOptions {
  double seconds = 2;  // per row
};

// Prints a Markdown table. Returns 0, or an exit code when a link could not be opened.
int ingest_bench(const IngestOptions& options);

}  // namespace fire3dv::bench
