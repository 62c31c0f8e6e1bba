#!/bin/sh
# What error.md, skip.md and startup.md show, measured again: SCENES is the folder of the .glb files, OUT gets JSON
# and figures. Nothing else should run meanwhile.
#   docs/measurements/errors.sh SCENES OUT
set -eu
scenes=$1 out=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
mkdir -p "$out"
cd "$root"
cargo build --release
programs=${CARGO_TARGET_DIR:-target}/release
for backend in cpu gpu; do
    for scene in crytek_sponza country_kitchen hotel_room; do
        camera=
        [ "$scene" != crytek_sponza ] || camera="--camera nave"
        # shellcheck disable=SC2086  # The camera is two words or none.
        error() {
            name=$1
            shift
            "$programs/recorder" bench error "$scenes/$scene.glb" $camera --backend $backend "$@" --json \
                > "$out/error-$name-$scene-$backend.json"
        }
        error precision --only precision --repeats 7
        if [ $backend = cpu ]; then
            error estimator --only estimator --repeats 7
            error key-bits --only key-bits --width 1920 --height 1080 --bounces 3 --key-bits 8,12,16,24,32 --repeats 5 \
                --methods origin,aila,two-point,two-point-adaptive,light-octahedron
            error image --only image --image-width 640 --image-height 360 --image-passes 16 --reference-passes 64 \
                --repeats 3 --methods aila,octahedron,two-point,two-point-adaptive,light-octahedron
        fi
        # shellcheck disable=SC2086
        "$programs/recorder" bench skip "$scenes/$scene.glb" $camera --backend $backend --repeats 7 --json \
            > "$out/skip-$scene-$backend.json"
    done
    "$programs/recorder" bench skip --backend $backend --repeats 15 --json > "$out/skip-builtin-$backend.json"
    "$programs/recorder" bench startup "$scenes/crytek_sponza.glb" "$scenes/country_kitchen.glb" "$scenes/hotel_room.glb" \
        "$scenes/dream_apartment.glb" "$scenes/aws_small_house.glb" --backend $backend --repeats 7 --json \
        > "$out/startup-$backend.json"
done
for result in "$out"/error-*.json "$out"/skip-*.json; do
    "$programs/inspector" plot "$result" --out "$out/figures-$(basename "$result" .json)"
done
