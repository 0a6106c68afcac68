#!/usr/bin/env bash
# Fills the corpora: the seeds of this folder, and the bad logs and example campaigns where the reference data is at hand.
set -euo pipefail
cd "$(dirname "$0")"
shared=${HYDROSYSID_SHARED:-../../shared}
mkdir -p corpus/log corpus/campaign corpus/fit
cp seeds/log/* corpus/log/
cp seeds/campaign/* corpus/campaign/
cp seeds/fit/* corpus/fit/
if [ -d "$shared/badlogs" ]; then
    # beyond 64 KiB a mutation hardly ever meets the place that matters
    find "$shared/badlogs" -name '*.csv' -size -64k -exec cp {} corpus/log/ \;
    find "$shared/badlogs" -name '*.csv' -size -16k -exec cp {} corpus/fit/ \;
fi
if [ -d "$shared/example_campaigns" ]; then
    for campaign in "$shared"/example_campaigns/*/campaign.toml; do
        cp "$campaign" "corpus/campaign/$(basename "$(dirname "$campaign")").toml"
    done
fi
echo "$(ls corpus/log | wc -l) logs, $(ls corpus/campaign | wc -l) campaigns, $(ls corpus/fit | wc -l) fits"
