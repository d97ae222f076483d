import numpy as np

from crazychoir_fw.recording.lettering import Labels, blend, pill, text


def test_labels_cover_neither_each_other_nor_a_point_nor_what_is_taken():
    random = np.random.default_rng(1)
    points = random.uniform(30, 270, (12, 2)).tolist()
    sizes, keys = [(40, 12)] * 12, [f"cf{k}" for k in range(12)]
    taken = (0.0, 0.0, 300.0, 40.0)
    labels = Labels(300, 300, [taken])
    places = labels.place(points, sizes, 6.0, keys)
    boxes = [(x, y, x + w, y + h) for (x, y), (w, h) in zip(filter(None, places), sizes, strict=False)]
    assert len(boxes) >= 9
    covered = np.zeros((300, 300), int)
    covered[:39] += 1
    for left, top, right, bottom in boxes:
        covered[top + 1 : bottom - 1, left + 1 : right - 1] += 1
    assert covered.max() == 1
    assert all(not covered[round(y), round(x)] for x, y in points if y > 45)
    assert labels.place(points, sizes, 6.0, keys) == places


def test_a_label_stays_on_its_side_while_its_neighbor_goes_away():
    labels = Labels(400, 400)
    first = labels.place([(200.0, 200.0), (205.0, 195.0)], [(60, 12)] * 2, 6.0, ["a", "b"])
    alone = labels.place([(np.nan, np.nan), (205.0, 195.0)], [(60, 12)] * 2, 6.0, ["a", "b"])
    assert alone == [None, first[1]]


def test_patches_are_laid_over_and_cut_off_at_the_edges():
    picture = np.full((20, 30, 3), 100, np.uint8)
    patch = np.zeros((10, 10, 4), np.uint16)
    patch[..., 0], patch[..., 3] = 200, 51  # a fifth
    blend(picture, patch, -5, 15)
    assert picture[17, 2].tolist() == [120, 80, 80]
    assert (picture[:15] == 100).all() and (picture[:, 5:] == 100).all()
    before = picture.copy()
    for x, y in ((-10, 0), (30, 0), (0, -10), (0, 20)):
        blend(picture, patch, x, y)
    np.testing.assert_array_equal(picture, before)


def test_words_have_ink():
    assert text("cf1", 14)[..., 3].max() == 255
    assert pill("12.3 s   2×", 14).shape[1] > text("12.3 s   2×", 14, is_bold=True).shape[1]
