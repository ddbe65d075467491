<!DOCTYPE PickedPoints>
<PickedPoints><point x="1" y="2" z="3" active="1" name="a"/></PickedPoints>